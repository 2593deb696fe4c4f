"""Walls that strokes were stopped by, on a plate whose face looks up."""

from types import SimpleNamespace

import numpy as np
import pytest

from exploration.control.sighting import Sighting
from exploration.planning.inferring.inferred_walls import inferred_walls, standing
from exploration.planning.touching.study import Wall
from primitives import pose as se3
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import fit

HALF = np.array([10.0, 10.0])
UP = np.array([0.0, 0.0, 1.0])


def flat(normal, offset):
    """A face felt on a grid."""
    turn = se3.frame_along(np.asarray(normal, dtype=float), None)
    grid = np.array([[x, y, 0.0] for x in range(-20, 21, 10) for y in range(-20, 21, 10)])
    points = grid @ turn.T + offset * np.asarray(normal)
    contacts = Contacts.of(points, np.broadcast_to(normal, points.shape))
    return SimpleNamespace(id=0, fit=fit("plane", contacts), contacts=contacts)


PLATE = [flat(UP, 0.0), flat([1.0, 0.0, 0.0], 40.0)]


def stopped(at, heading, turn=0.0):
    """A stop of a pad that lies on the plate, turned about its normal by `turn` [rad]."""
    facing = se3.rotation_exp([0.0, 0.0, turn]) @ np.diag([1.0, -1.0, -1.0])
    way = np.asarray(heading, dtype=float)
    return Wall(np.array(at) + 9.0 * way, way, UP, se3.pose(facing, at), HALF)


def test_two_stops_in_a_row_make_a_plane_where_the_housing_was():
    rng = np.random.default_rng(0)
    stops = [stopped([10.0 + rng.normal(0.0, 0.1), y, 0.0], [1.0, 0.0, 0.0]) for y in (-12.0, 0.0, 12.0)]
    (lot,) = inferred_walls(stops, PLATE)
    assert lot.points[:, 0] == pytest.approx(20.0, abs=0.2)
    assert lot.normals == pytest.approx(np.broadcast_to([-1.0, 0.0, 0.0], lot.normals.shape))
    assert (lot.touch == NOT_FELT).all()
    found = fit("plane", lot)
    assert abs(found.shape.direction @ [1.0, 0.0, 0.0]) == pytest.approx(1.0, abs=1e-6)


def test_a_turned_pad_is_stopped_at_its_corner():
    turn = 0.3
    reach = 10.0 * (np.cos(turn) + np.sin(turn))
    stops = [stopped([20.0 - reach, y, 0.0], [1.0, 0.0, 0.0], turn) for y in (-10.0, 10.0)]
    (lot,) = inferred_walls(stops, PLATE)
    assert lot.points[:, 0] == pytest.approx(20.0)


def test_one_stop_and_stops_at_one_place_tell_nothing():
    one = stopped([10.0, 0.0, 0.0], [1.0, 0.0, 0.0])
    assert inferred_walls([one], PLATE) == []
    assert inferred_walls([one, stopped([10.1, 0.5, 0.0], [1.0, 0.0, 0.0])], PLATE) == []


def at_walls(*places, face=0.0):
    """Stops at (x of the wall, y), of pads on a face at a height."""
    return [stopped([x - 10.0, y, face], [1.0, 0.0, 0.0]) for x, y in places]


def test_stops_on_one_face_that_lie_anywhere_agree_by_chance():
    agree, anywhere = [(20.0, -6.0), (20.0, 6.0)], [(18.0, -3.0), (15.5, 3.0), (22.0, 0.0)]
    assert len(inferred_walls(at_walls(*agree), PLATE)) == 1
    assert inferred_walls(at_walls(*agree, *anywhere), PLATE) == []


@pytest.mark.parametrize(
    ("stops", "walls"),
    [
        (
            at_walls((20.0, -20.0), (20.0, -12.0), (15.0, -8.0), (15.0, 0.0), (15.0, 8.0)),
            [20.0, 15.0],
        ),  # a jog
        (
            [*at_walls((20.0, -6.0), (20.0, 6.0)), *at_walls((26.0, -6.0), (26.0, 6.0), face=8.0)],
            [20.0, 26.0],
        ),
        (at_walls((20.0, -6.0), (20.9, 0.0), (21.05, 6.0), (21.1, -12.0)), [20.45, 21.075]),
    ],
)
def test_walls_beside_each_other_do_not_deny_each_other(stops, walls):
    lots = inferred_walls(stops, [*PLATE, flat(UP, 8.0)])
    assert sorted(float(np.median(lot.points[:, 0])) for lot in lots) == pytest.approx(sorted(walls))


def test_a_rim_that_was_seen_makes_a_wall_of_one_stop_whatever_lies_beside():
    rim = Sighting(
        np.array([20.0, 12.0, 0.0]), np.array([0.0, 1.0, 0.0]), np.array([-1.0, 0.0, 0.0]), UP, 0.05, 12.0
    )
    strays = at_walls((18.0, -3.0), (23.0, 3.0))
    assert len(inferred_walls([*at_walls((20.0, 0.0)), *strays], PLATE, [rim])) == 1


def test_bosses_between_which_the_floor_goes_on_are_no_wall_and_a_rib_is_one():
    stops = [stopped([-1.8, y, 0.0], [1.0, 0.0, 0.0]) for y in (-15.0, 15.0)]
    assert inferred_walls(stops, PLATE) == []  # at x = 8.2, and the plate was felt at x = 10
    behind_a_rib = [stopped([-6.0, y, 0.0], [1.0, 0.0, 0.0]) for y in (-15.0, 15.0)]
    assert len(inferred_walls(behind_a_rib, PLATE)) == 1


def test_a_block_that_stands_in_the_middle_of_a_plate_has_a_wall():
    grid = np.array([[x, y, 0.0] for x in range(-60, 61, 2) for y in range(-60, 61, 2)], dtype=float)
    outside = grid[(np.abs(grid[:, 0] - 20.0) > 12.0) | (np.abs(grid[:, 1]) > 22.0)]
    contacts = Contacts.of(outside, np.broadcast_to(UP, outside.shape))
    plate = SimpleNamespace(id=0, fit=fit("plane", contacts), contacts=contacts)
    stops = [stopped([0.0, y, 0.0], [1.0, 0.0, 0.0]) for y in (-16.0, 0.0, 16.0)]
    (lot,) = inferred_walls(stops, [plate, PLATE[1]])
    assert lot.points[:, 0] == pytest.approx(10.0)


def test_stops_round_a_boss_make_no_plane():
    stops = []
    for angle in np.linspace(0.0, 2 * np.pi, 8, endpoint=False):
        way = np.array([np.cos(angle), np.sin(angle), 0.0])
        stops.append(stopped(-way * 32.0, way, angle))
    assert inferred_walls(stops, PLATE) == []


def test_a_pad_that_leans_infers_nothing():
    leaning = se3.rotation_exp([0.0, 0.4, 0.0]) @ np.diag([1.0, -1.0, -1.0])
    stops = []
    for y in (-12.0, 12.0):
        at, way = [10.0, y, 0.0], leaning[:, 0]
        stops.append(Wall(np.array(at) + 9.0 * way, way, -leaning[:, 2], se3.pose(leaning, at), HALF))
    assert inferred_walls(stops, PLATE) == []


def test_a_housing_that_leans_over_may_have_been_stopped_anywhere_up_its_side():
    def leaning(angle):
        turn = se3.rotation_exp([0.0, angle, 0.0]) @ np.diag([1.0, -1.0, -1.0])
        face = flat(-turn[:, 2], 0.0)
        at = [np.array([0.0, y, 0.0]) for y in (-12.0, 12.0)]
        stops = [Wall(p + 9.0 * turn[:, 0], turn[:, 0], -turn[:, 2], se3.pose(turn, p), HALF) for p in at]
        return inferred_walls(stops, [face, PLATE[1]])

    assert len(leaning(-0.1)) == 1
    assert leaning(0.1) == []


def test_a_rim_that_ends_where_a_pad_was_stopped_tells_the_wall_and_where_it_stands():
    one = stopped([10.0, 0.0, 0.0], [1.0, 0.0, 0.0])
    x, y, z = np.eye(3)

    def rim(at):
        return Sighting(np.array(at), y, -x, z, 0.05, 10.0)

    (lot,) = inferred_walls([one], PLATE, [rim([20.3, 9.0, 8.0])])
    assert lot.points[:, 0] == pytest.approx(20.3, abs=0.01)
    assert inferred_walls([one], PLATE, [rim([23.0, 9.0, 8.0])]) == []


def test_a_wall_that_an_array_has_gone_through_was_none():
    stops = [stopped([10.0, y, 0.0], [1.0, 0.0, 0.0]) for y in (-12.0, 0.0, 12.0)]
    (lot,) = inferred_walls(stops, PLATE)
    x, y, z = np.meshgrid([23.0], np.arange(-12.0, 13.0, 4.0), [2.0, 4.0, 6.0])
    behind = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    assert standing(lot, behind) is None
    assert standing(lot, behind - [8.0, 0.0, 0.0]) is lot
    assert len(standing(lot, behind - [0.0, 60.0, 0.0])) == len(lot)


def test_a_wall_with_a_free_corner_stands_where_no_array_has_been_behind_it():
    stops = [stopped([10.0, y, 0.0], [1.0, 0.0, 0.0]) for y in (-16.0, 0.0, 16.0)]
    (lot,) = inferred_walls(stops, PLATE)
    x, y, z = np.meshgrid([23.0], np.arange(10.0, 26.0, 2.0), [2.0, 4.0, 6.0])
    left = standing(lot, np.column_stack([x.ravel(), y.ravel(), z.ravel()]))
    assert left is not None
    assert 0 < len(left) < len(lot)
    assert left.points[:, 1].max() < 8.0
