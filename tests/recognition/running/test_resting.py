"""Parts that lie on a table."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from models import parts
from models.csg import Cube
from models.solid import Solid
from primitives import pose as se3
from primitives.errors import PalpateError
from recognition.running.resting import resting_attitude


@pytest.mark.parametrize("name", ["block", "wedge", "frustum", "bracket", "bearing_block"])
@pytest.mark.parametrize("seed", range(4))
def test_a_part_lies_on_a_facet_under_its_middle_of_mass(name, seed):
    solid = Solid.from_csg(parts.build(name))
    turned = solid.placed(se3.pose(resting_attitude(solid, np.random.default_rng(seed)), np.zeros(3)))
    low = turned.vertices[:, 2] < turned.bounds[0, 2] + 1e-2
    outline = ConvexHull(turned.vertices[low][:, :2])
    middle = trimesh.Trimesh(turned.vertices, turned.triangles, process=False).center_mass
    assert (outline.equations[:, :2] @ middle[:2] + outline.equations[:, 2] < 1e-6).all()


def test_larger_facets_are_lain_on_more_often():
    solid, rng = Solid.from_csg(Cube((60.0, 40.0, 10.0))), np.random.default_rng(0)
    heights = [np.ptp(solid.vertices @ resting_attitude(solid, rng).T, axis=0)[2] for _ in range(60)]
    assert np.mean(np.isclose(heights, 10.0)) > 0.5


def test_a_flat_part_is_refused_in_one_line():
    flat = Solid.from_csg(Cube((60.0, 40.0, 10.0)))
    flat = type("Flat", (), {"vertices": flat.vertices * [1, 1, 0], "triangles": flat.triangles})()
    with pytest.raises(PalpateError, match="flat"):
        resting_attitude(flat, np.random.default_rng(0))
