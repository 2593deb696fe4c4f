"""The polyhedron round a body, and the ways out of it."""

import numpy as np
import pytest

from primitives.pose import pose, random_rotation
from primitives.shapes import Cone, Cylinder, Plane, Sphere
from recognition.assembly.closure import hull

BOX = np.array([[-300.0] * 3, [300.0] * 3])
UP = np.array([0, 0, 1.0])


def block(world, half=(30.0, 20.0, 15.0)):
    axes = np.eye(3)
    planes = [Plane(s * h * axes[i], s * axes[i]) for i, h in enumerate(half) for s in (-1.0, 1.0)]
    return [p.transformed(world) for p in planes]


@pytest.mark.parametrize("seed", range(5))
def test_a_block_has_eight_corners_and_its_own_areas_at_any_pose(seed):
    rng = np.random.default_rng(seed)
    world = pose(random_rotation(rng), rng.uniform(-100, 100, 3))
    found = hull(block(world), BOX)
    assert found
    assert len(np.unique(np.round(found.corners, 6), axis=0)) == 8
    assert found.area == pytest.approx([1200, 1200, 1800, 1800, 2400, 2400])


def test_round_bodies_are_held_with_little_to_spare():
    caps = [Plane(20 * UP, UP), Plane(-20 * UP, -UP)]
    rod = hull([Cylinder(np.zeros(3), UP, 15.0), *caps], BOX)
    cone = hull([Cone(30 * UP, -UP, np.arctan(0.5)), Plane(np.zeros(3), -UP)], BOX)
    ball = hull([Sphere(np.zeros(3), 25.0)], BOX)
    assert rod.area == pytest.approx([2 * np.pi * 15 * 40, np.pi * 225, np.pi * 225], rel=0.005)
    assert cone.area[1] == pytest.approx(np.pi * 225, rel=0.005)
    assert ball.area[0] == pytest.approx(4 * np.pi * 625, rel=0.02)
    assert np.linalg.norm(ball.corners, axis=1).min() >= 25.0


def test_a_plane_outside_has_no_area():
    stray = Plane(np.array([100.0, 0, 0]), np.array([1.0, 0, 0]))
    assert hull([*block(np.eye(4)), stray], BOX).area[6] == 0.0


def test_a_rod_without_a_cap_is_open_along_its_axis():
    found = hull([Cylinder(np.zeros(3), UP, 15.0), Plane(-20 * UP, -UP)], BOX)
    assert not found
    assert np.allclose(found.directions, [UP], atol=0.01)
    assert found.open_faces == (0,)


def test_a_cone_open_at_its_wide_end_is_not_closed():
    found = hull([Cone(np.zeros(3), UP, 0.3)], BOX)
    assert np.allclose(found.directions, [UP], atol=0.01)


def test_sides_that_meet_only_far_outside_the_workspace_do_not_close():
    lean = np.array([0.001, 0, 1.0])
    nearly = [*block(np.eye(4))[2:], Plane(np.zeros(3), np.array([1.0, 0, 0.0]))]
    nearly[2] = Plane(-15 * UP, -UP)
    nearly[3] = Plane(15 * UP, lean / np.linalg.norm(lean))
    assert not hull(nearly, BOX)


def test_faces_without_room_between_them_contradict_each_other():
    found = hull([Plane(np.zeros(3), UP), Plane(5 * UP, -UP)], BOX)
    assert not found
    assert "contradict" in found.reason


def test_no_face_leaves_every_way_open():
    assert len(hull([], BOX).directions) == 6
