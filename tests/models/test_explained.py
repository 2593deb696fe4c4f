"""How much of a solid's area its boundary explains."""

import numpy as np
import pytest

from models.body import LabeledSurface
from models.csg import Cube
from models.explained import freeform_area_fraction, unassigned_area_fraction
from models.solid import Solid
from primitives.shapes import Plane

SIDES = np.concatenate([np.eye(3), -np.eye(3)])


def block(lifted=0.0, freeform=False):
    """A block of 60 x 40 x 20 mm; the surface said of its top is `lifted` [mm] off it, or none at all."""
    whole = Solid.from_csg(Cube((60, 40, 20)))
    half = np.array([30.0, 20.0, 10.0])
    reach = SIDES @ np.diag(half)
    reach[2, 2] += lifted
    surfaces = [LabeledSurface(Plane(p, n), True, 0) for p, n in zip(reach, SIDES, strict=True)]
    if freeform:
        surfaces[2] = LabeledSurface(None, True, -1)
    labels = np.argmax(whole.body.triangle_normals @ SIDES.T, axis=1)
    return Solid.from_labeled(whole.body.vertices, whole.body.triangles, labels, tuple(surfaces))


def test_a_sound_boundary_explains_everything():
    assert unassigned_area_fraction(block()) == 0
    assert freeform_area_fraction(block()) == 0


def test_triangles_off_their_surface_are_unassigned():
    top = 60 * 40 / (2 * (60 * 40 + 60 * 20 + 40 * 20))
    assert unassigned_area_fraction(block(lifted=0.5)) == pytest.approx(top)


def test_a_freeform_face_is_said_apart():
    top = 60 * 40 / (2 * (60 * 40 + 60 * 20 + 40 * 20))
    assert freeform_area_fraction(block(freeform=True)) == pytest.approx(top)
    assert unassigned_area_fraction(block(freeform=True)) == 0
