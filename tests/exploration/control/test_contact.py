"""Closed loops in simulation: landing, stroking and tracking on solids whose truth the test knows."""

import numpy as np
import pytest

from exploration.control.procedures import land as landing
from exploration.control.procedures.land import AS_TOLD, LandConfig, land
from exploration.control.procedures.settle import AS_IT_CAME, SettleConfig
from exploration.control.track_edge import follow_edge
from exploration.control.track_surface import follow_surface
from exploration.devices.guard import Collision
from models.csg import Cube, Cylinder, Sphere
from primitives import pose as se3

DOWN = np.diag([1.0, -1.0, -1.0])


def leaning(tilt_deg: float, at: tuple[float, float, float]):
    turn = se3.rotation_exp(np.radians(tilt_deg) * np.array([0.6, 0.8, 0.0]))
    return se3.pose(turn @ DOWN, at)


@pytest.mark.parametrize("tilt", [0.0, 15.0, 35.0])
def test_a_tilted_pad_rolls_flush_on_a_face(over, tilt):
    guard, _ = over(Cube((80.0, 80.0, 40.0)), leaning(tilt, (0.0, 0.0, 40.0)))
    felt = land(guard, guard.world_from_sensor[:3, 2], 60.0, 25.0)
    assert felt
    assert guard.world_from_sensor[:3, 2] @ [0.0, 0.0, -1.0] > np.cos(np.radians(1.5))
    assert abs(guard.world_from_sensor[2, 3] - (20.0 - 0.5)) < 0.15


@pytest.mark.parametrize("aside", [0.0, 1.5])
@pytest.mark.parametrize("width", [8.0, 10.0, 12.0])
def test_a_pad_over_a_slot_lies_on_both_its_lands_hardly_deeper_than_on_a_face(over, width, aside):
    slotted = Cube((60.0, 60.0, 30.0)) - Cube((80.0, width, 10.0)).at(0.0, aside, 15.0)
    guard, _ = over(slotted, leaning(0.0, (0.0, 0.0, 20.0)))
    assert land(guard, guard.world_from_sensor[:3, 2], 10.0, 25.0)
    assert 15.0 - guard.world_from_sensor[2, 3] < 0.9
    assert guard.world_from_sensor[2, 2] < -np.cos(np.radians(2.0))


def test_a_pad_that_meets_a_vertex_beside_its_middle_rolls_onto_one_of_its_faces(over):
    corner = se3.rotation_exp([0.0, np.arctan(np.sqrt(2.0)), 0.0]) @ se3.rotation_exp([0.0, 0.0, np.pi / 4])
    guard, solid = over(Cube((40.0, 40.0, 40.0)).placed(se3.pose(corner)), se3.pose(DOWN, [6.0, 3.0, 60.0]))
    assert land(guard, np.array([0.0, 0.0, -1.0]), 60.0, 25.0)
    facing = -solid.normals(guard.world_from_sensor[:3, 3][None])[0] @ guard.world_from_sensor[:3, 2]
    assert facing > np.cos(np.radians(2.0))


def test_landing_on_nothing_is_a_false_answer_that_says_why(over):
    guard, _ = over(Cube((20.0, 20.0, 20.0)), se3.pose(DOWN, [200.0, 0.0, 40.0]))
    missed = land(guard, np.array([0.0, 0.0, -1.0]), 60.0, 50.0)
    assert not missed
    assert "nothing" in missed.reason


@pytest.mark.parametrize(("config", "turned"), [(AS_TOLD, False), (LandConfig(), True)])
def test_a_pad_whose_housing_is_in_the_way_leans_unless_it_is_to_lie_as_told(
    over, monkeypatch, config, turned
):
    def blocked(*_):
        raise Collision("collision of lts210", None)

    monkeypatch.setattr(landing, "advance", blocked)
    guard, _ = over(Cube((200.0, 200.0, 40.0)), leaning(0.0, (0.0, 0.0, 40.0)))
    before = guard.world_from_sensor[:3, :3]
    assert not land(guard, np.array([0.0, 0.0, -1.0]), 20.0, 25.0, config)
    assert (se3.turn_between(before, guard.world_from_sensor[:3, :3]) > 0.4) is turned


@pytest.mark.parametrize(("settling", "stays"), [(AS_IT_CAME, True), (SettleConfig(), False)])
def test_a_pad_across_a_narrow_wall_stays_at_the_attitude_it_came_at_unless_it_rolls(over, settling, stays):
    wall = Cube((80.0, 2.0, 40.0))
    guard, _ = over(wall, leaning(4.0, (0.0, 0.0, 40.0)))
    before = guard.world_from_sensor[:3, :3]
    land(guard, np.array([0.0, 0.0, -1.0]), 60.0, 25.0, AS_TOLD, settling)
    assert (se3.turn_between(before, guard.world_from_sensor[:3, :3]) < 1e-3) is stays
    if stays:
        assert abs(guard.world_from_sensor[2, 3] - 20.0) < 1.2


def test_a_stroke_on_a_face_stops_short_of_its_edge_and_measures_the_face(over):
    guard, _ = over(Cube((100.0, 60.0, 30.0)), se3.pose(DOWN, [-20.0, 0.0, 20.0]))
    assert land(guard, np.array([0.0, 0.0, -1.0]), 20.0, 25.0)
    stroke = follow_surface(guard, np.array([1.0, 0.0]), 200.0, touch=1, stroke=1)
    assert stroke.ended == "edge"
    assert 40.0 < guard.world_from_sensor[0, 3] < 50.0
    assert len(stroke.contacts) > 20
    np.testing.assert_allclose(stroke.contacts.points[:, 2], 15.0, atol=0.05)
    edge = min(stroke.edges, key=lambda e: abs(e.point[0] - 50.0))
    assert abs(edge.point[0] - 50.0) < 0.3
    assert edge.outward @ [1.0, 0.0, 0.0] > 0.99


@pytest.mark.slow
def test_a_stroke_goes_round_a_sphere_and_stays_on_it(over):
    guard, solid = over(Sphere(25.0), se3.pose(DOWN, [0.0, 0.0, 30.0]))
    assert land(guard, np.array([0.0, 0.0, -1.0]), 20.0, 25.0)
    stroke = follow_surface(guard, np.array([1.0, 0.0]), 200.0, touch=1, stroke=1)
    assert stroke.ended == "closed"
    off = solid.signed_distance(stroke.contacts.points)
    assert np.sqrt(np.mean(off**2)) < 0.06


def test_a_straight_edge_is_tracked_to_its_corner(over):
    guard, _ = over(Cube((100.0, 60.0, 30.0)), se3.pose(DOWN, [0.0, 29.0, 20.0]))
    assert land(guard, np.array([0.0, 0.0, -1.0]), 20.0, 25.0)
    tracked = follow_edge(guard, np.array([1.0, 0.0, 0.0]), 200.0, touch=1, stroke=1)
    assert tracked
    assert tracked.ended == "corner"
    points = tracked.trace.points
    assert 44.0 < points[-1, 0] < 52.0
    assert np.sqrt(np.mean((points[:, 1] - 30.0) ** 2)) < 0.25


def test_a_circular_edge_is_tracked_until_it_closes(over):
    guard, _ = over(Cylinder(30.0, 20.0), se3.pose(DOWN, [28.0, 0.0, 15.0]))
    assert land(guard, np.array([0.0, 0.0, -1.0]), 20.0, 25.0)
    tracked = follow_edge(guard, np.array([0.0, 1.0, 0.0]), 400.0, touch=1, stroke=1)
    assert tracked.ended == "closed"
    assert tracked.trace.closed
    radius = np.hypot(*tracked.trace.points[:, :2].T)
    assert abs(np.median(radius) - 30.0) < 0.3
