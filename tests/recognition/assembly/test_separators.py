"""Where a hole ends that was found on one side of a round body alone, and a round body that no face ends."""

import numpy as np

from primitives.shapes import Cylinder, Plane
from recognition.assembly.separators import felt_ends, one_sided

X, Y, Z = np.eye(3)
COLLAR = Cylinder(np.array([5.0, 3.0, 0.0]), Z, 28.0)
SCREW = Cylinder(np.array([5.0, 3.0, 11.0]), X, 4.0)
NOBODY = np.empty((0, 3)), np.empty((0, 3))


def wall(*along, of=SCREW, side=-1.0):
    """Contacts round a hole at some heights along it, or round a pin."""
    turn = np.linspace(0.0, 2.0 * np.pi, 12)
    ring = np.outer(np.cos(turn), of.frame[:, 0]) + np.outer(np.sin(turn), of.frame[:, 1])
    points = [of.origin + x * of.axis + of.radius * ring for x in along]
    return np.concatenate(points), np.tile(side * ring, (len(along), 1))


def test_a_hole_found_in_one_wall_may_end_at_the_bodys_axis():
    (plane,) = one_sided([COLLAR, SCREW], [NOBODY, wall(16.0, 26.0)])
    assert isinstance(plane, Plane)
    assert abs(plane.normal @ X) > 0.999
    assert abs((plane.origin - COLLAR.origin) @ X) < 1e-9
    assert one_sided([COLLAR, SCREW, plane], [NOBODY, wall(-16.0, -26.0)]) == []  # it is there already


def test_one_found_in_both_walls_or_beside_the_body_or_along_it_goes_through_and_a_spoke_is_none():
    assert one_sided([COLLAR, SCREW], [NOBODY, wall(-20.0, 20.0)]) == []
    assert one_sided([COLLAR, SCREW], [NOBODY, wall(16.0, 26.0, side=1.0)]) == []
    beside, along = (
        Cylinder(SCREW.origin + shift, axis, 4.0) for shift, axis in ((40.0 * Y, X), (8.0 * X, Z))
    )
    assert one_sided([COLLAR, beside], [NOBODY, wall(16.0, of=beside)]) == []
    assert one_sided([COLLAR, along], [NOBODY, wall(16.0, of=along)]) == []


def test_a_round_body_ends_past_where_it_was_felt_last_and_at_a_face_that_is_near():
    felt = [wall(-20.0, 9.0, of=COLLAR, side=1.0), NOBODY]
    cap = Plane(np.array([0.0, 0.0, 11.0]), Z)
    (end,) = felt_ends([COLLAR, cap], felt, [False, False])
    assert abs(end.normal @ Z) > 0.999
    assert -23.0 < end.origin[2] < -20.0
    low, high = sorted(plane.origin[2] for plane in felt_ends([COLLAR], felt[:1], [False]))
    assert low < -20.0
    assert high > 9.0


def test_the_contacts_of_an_inferred_wall_tell_nothing_of_its_ends():
    felt = [wall(-20.0, 9.0, of=COLLAR, side=1.0)]
    assert felt_ends([COLLAR], felt, [True]) == []
    assert felt_ends([COLLAR], [NOBODY], [False]) == []
