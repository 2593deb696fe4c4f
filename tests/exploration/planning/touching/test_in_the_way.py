"""What of all that was felt stands in the way, and what a housing came to."""

from types import SimpleNamespace

import numpy as np

from exploration.planning.known.surface_map import SurfaceMap
from exploration.planning.touching.overhung import Overhung
from exploration.planning.touching.reach import Reach, ReachConfig
from exploration.planning.touching.study import Wall
from exploration.planning.ways.routes import RoutesConfig, Tool
from primitives.pose import pose

UP = np.array([0.0, 0.0, 1.0])
TOOL = Tool(np.array([-10.0, -10.0, -40.0]), np.array([10.0, 10.0, 0.0]))
LAID = np.diag([1.0, -1.0, -1.0, 1.0])  # (4, 4) of a pad that faces down


def places_kept(suspect, gone):
    """How many places ways keep off, in turn, of two that were felt; `gone` of them were gone through since."""
    felt = np.array([[0.0, 0.0, 5.0], [0.0, 0.0, 9.0]])
    reach = Reach.__new__(Reach)
    reach.lids, reach._suspect = (np.empty((0, 3)), np.empty((0, 3))), np.zeros((suspect, 3))
    reach._obstacles = lambda: felt
    reach.pad = SimpleNamespace(swept=SimpleNamespace(holds=lambda places: np.arange(len(places)) < gone))
    return [len(places) for places in reach._in_the_way()]


def test_what_was_gone_through_is_left_out_last_and_only_where_there_is_some():
    assert places_kept(suspect=0, gone=0) == [2]
    assert places_kept(suspect=3, gone=1) == [5, 2, 1]


def overhung(at, facing):
    """Whether a stop along x is put down to one place felt, of a housing that reaches 10 mm to each side."""
    wall = Wall(np.array([10.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0]), UP, LAID, np.array([10.0, 10.0]))
    asked, felt = Overhung(), SurfaceMap()
    assert not asked.holds(wall, felt, TOOL)
    felt.add(np.array([at]), np.array([facing]))
    found = asked.holds(wall, felt, TOOL)
    felt.add(np.array([[0.0, 50.0, 0.0]]), np.array([[0.0, 0.0, 1.0]]))
    assert asked.holds(wall, felt, TOOL) == found
    return found


def test_a_stop_is_put_down_to_what_the_housing_came_to_above_the_skin():
    against, away = [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]
    assert overhung([11.0, 0.0, 25.0], against)
    assert not overhung([11.0, 0.0, 25.0], away)
    assert not overhung([11.0, 0.0, 1.0], against)  # at the skin: this is the wall itself
    assert not overhung([16.0, 0.0, 25.0], against)
    assert not overhung([-11.0, 0.0, 25.0], against)


def gone(start, wall):
    """Where a pad flies to from (4, 4) `start` to 60 mm above it, with `wall` felt; whether it was led there."""
    flown: list[np.ndarray] = []
    guard = SimpleNamespace(world_from_sensor=start)

    def go_to(pose, until=None):
        guard.world_from_sensor = pose
        flown.append(pose)

    guard.go_to = go_to
    reach = Reach.__new__(Reach)
    reach.config, reach._routes, reach._barred = ReachConfig(), (RoutesConfig(),), []
    reach.lids, reach._suspect = (np.empty((0, 3)), np.empty((0, 3))), np.empty((0, 3))
    reach._obstacles, reach._ways = (lambda: wall), (lambda: UP[None])
    reach._legs = lambda goal: [(goal, True)]
    swept = SimpleNamespace(holds=lambda places: np.zeros(len(places), dtype=bool))
    reach.pad = SimpleNamespace(guard=guard, tool=TOOL, swept=swept)
    arrived = reach.go(start @ pose(translation=[30.0, 0.0, -60.0]))
    return arrived, flown


def test_a_pad_in_an_inside_corner_goes_straight_off_before_it_goes_round():
    up, along = np.meshgrid(np.arange(0.5, 12.0, 1.5), np.arange(-9.0, 10.0, 1.5))
    beside = np.column_stack([np.full(up.size, -10.2), along.ravel(), up.ravel()])
    arrived, flown = gone(LAID, beside)
    assert arrived
    assert np.allclose(flown[0][:3, 3], ReachConfig().rise * UP)
    arrived, flown = gone(LAID, beside - [20.0, 0.0, 0.0])
    assert arrived
    assert not np.allclose(flown[0][:3, 3], ReachConfig().rise * UP)
