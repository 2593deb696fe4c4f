"""Where a hole ends that was found on one side of a round body alone."""

import numpy as np

from primitives.shapes import Cylinder, Plane
from recognition.assembly.separators import one_sided

X, Z = np.eye(3)[0], np.eye(3)[2]
COLLAR = Cylinder(np.array([5.0, 3.0, 0.0]), Z, 28.0)
SCREW = Cylinder(np.array([5.0, 3.0, 11.0]), X, 4.0)
NOBODY = np.empty((0, 3))


def wall(*along):
    turn = np.linspace(0.0, 2.0 * np.pi, 12)
    return np.concatenate(
        [[5.0 + x, 3.0, 11.0] + 4.0 * np.stack([0 * turn, np.cos(turn), np.sin(turn)], 1) for x in along]
    )


def test_a_hole_found_in_one_wall_may_end_at_the_bodys_axis():
    (plane,) = one_sided([COLLAR, SCREW], [NOBODY, wall(16.0, 26.0)])
    assert isinstance(plane, Plane)
    assert abs(plane.normal @ X) > 0.999
    assert abs((plane.origin - COLLAR.origin) @ X) < 1e-9
    assert len(one_sided([COLLAR, SCREW, plane], [NOBODY, wall(-16.0, -26.0)])) == 0  # it is there already


def test_one_found_in_both_walls_or_beside_the_body_or_along_it_goes_through():
    assert one_sided([COLLAR, SCREW], [NOBODY, wall(-20.0, 20.0)]) == []
    beside = Cylinder(SCREW.origin + np.array([0.0, 40.0, 0.0]), X, 4.0)
    assert one_sided([COLLAR, beside], [NOBODY, wall(16.0) + np.array([0.0, 40.0, 0.0])]) == []
    assert one_sided([COLLAR, Cylinder(SCREW.origin + 8.0 * X, Z, 4.0)], [NOBODY, wall(16.0)]) == []
