"""A mesh with fewer triangles stays the object that it stands for."""

import numpy as np
import pytest

from models import parts
from models.library import surface_samples
from models.library.thinned import thinned
from models.solid import Solid


@pytest.mark.slow
@pytest.mark.parametrize("name", ["eyebolt", "knob"])
@pytest.mark.parametrize("drawn", [True, False])
def test_round_parts_keep_their_surface(name, drawn):
    solid = Solid.from_csg(parts.build(name), 0.005)
    if not drawn:
        solid = Solid(solid.body, solid.pose, None)
    vertices, triangles, of_face = thinned(solid, solid.face_of_triangle, 3000)
    assert len(triangles) < 0.6 * len(solid.triangles)
    assert len(of_face) == len(triangles)
    coarse = Solid.from_mesh(vertices, triangles)
    away = np.abs(coarse.signed_distance(surface_samples(solid).points))
    assert away.max() < 2.5e-3 * solid.extent.max()
