"""What of all that was felt stands in the way, and what a housing came to."""

from types import SimpleNamespace

import numpy as np

from exploration.planning.known.surface_map import SurfaceMap
from exploration.planning.touching.overhung import Overhung
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Wall
from exploration.planning.ways.routes import Tool

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
