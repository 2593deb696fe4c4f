import numpy as np
import pytest

from primitives.segmentation.unrolled import unrolled
from primitives.shapes import Cone, Cylinder, Plane, Sphere

ORIGIN, AXIS = np.array([3.0, -2.0, 7.0]), np.array([2.0, -1.0, 2.0]) / 3.0


@pytest.mark.parametrize(
    "shape", [Plane(ORIGIN, AXIS), Cylinder(ORIGIN, AXIS, 9.0), Cone(ORIGIN, AXIS, 0.4)], ids=lambda s: s.kind
)
def test_neighbors_on_a_shape_are_as_far_apart_when_it_lies_flat(shape):
    rng = np.random.default_rng(0)
    ways = rng.normal(size=(60, 3))
    here = shape.project(ORIGIN + 30 * AXIS + 8 * ways)
    there = shape.project(here + 0.01 * rng.normal(size=(60, 3)))
    flat = unrolled(shape, np.concatenate([here, there]))
    steps = np.linalg.norm(flat[:60] - flat[60:], axis=1)
    assert np.median(np.abs(steps / np.linalg.norm(here - there, axis=1) - 1)) < 1e-3


def test_a_cylinder_is_slit_where_nothing_was_felt():
    turn = np.linspace(2.5, 4.0, 20)  # across the half plane at which angles jump
    ring = 5 * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    flat = unrolled(Cylinder(np.zeros(3), [0, 0, 1.0], 5.0), ring)
    assert np.ptp(flat[:, 0]) == pytest.approx(5 * 1.5)


def test_a_sphere_does_not_lie_flat():
    assert unrolled(Sphere(ORIGIN, 4.0), np.zeros((3, 3))) is None
