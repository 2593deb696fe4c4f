"""The pad comes to a place by the attitude that is nearer, and tells about how long that takes."""

import numpy as np
import pytest

from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.planning.touching.pad import Pad
from exploration.planning.touching.reach import Reach
from exploration.planning.ways.routes import RoutesConfig, Tool
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cube
from models.solid import Solid
from primitives import pose as se3

UP, X = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
SPEC = load_sensor("lts210")
BOX = np.array([-150.0, -150.0, -150.0, 150.0, 150.0, 150.0])


def pad_at(x, z):
    """A pad beside or over a block of 80 x 80 x 60 mm."""
    high = se3.pose(se3.frame_along(-UP, X), [x, 0.0, z])
    solid = Solid.from_csg(Cube((80.0, 80.0, 60.0)))
    stage, arrays = simulate(solid, [SPEC], np.random.default_rng(0), start_pose=high)
    guard = Guard(stage, arrays, [Calibration.nominal(SPEC)])
    tools = Tool.each([SPEC], [array.flange_from_sensor for array in arrays])
    return Pad(guard, BOX, lambda kind, detail: None, tools=tools)


@pytest.fixture
def pad():
    """Over the block."""
    return pad_at(0.0, 60.0)


@pytest.mark.parametrize("along", [X, -X])
def test_a_pad_is_not_turned_round_where_half_a_turn_leaves_it_the_same(pad, along):
    before = pad.guard.world_from_sensor[:3, 0]
    assert Reach(pad).touch(se3.pose(pad.attitude(UP, along), [10.0, 0.0, 30.0]))
    assert pad.guard.world_from_sensor[:3, 0] @ before > 0.99


def test_the_time_to_a_place_grows_with_the_way_and_with_the_turn(pad):
    reach = Reach(pad)
    here = pad.guard.world_from_sensor[:3, 3]
    near, far = here + 10.0 * X, here + 90.0 * X
    level, aside, under = reach.seconds_to(np.array([near] * 3), np.array([UP, X, -UP]))
    assert 0.0 < level < aside < under
    assert reach.seconds_to(far, UP) > level


def test_a_pad_that_is_shut_in_goes_back_the_way_it_came():
    """In from the side and far along: only where it came from does anything lead out."""
    pad = pad_at(-140.0, 120.0)
    reach, down = Reach(pad), pad.guard.world_from_sensor[:3, :3]
    for aside, high in ((-140.0, 40.0), (60.0, 40.0)):
        pad.guard.go_to(se3.pose(down, [aside, 0.0, high]))
    x, y = (g.ravel() for g in np.meshgrid(np.arange(-110.0, 150.0, 3.0), np.arange(-30.0, 31.0, 3.0)))
    lids = [np.column_stack([x, y, np.full(len(x), high)]) for high in (30.0, 95.0)]
    sides = [np.column_stack([x, np.full(len(x), side), 65.0 + y]) for side in (-30.0, 30.0)]
    end = np.column_stack([np.full(len(x), 100.0), x, 65.0 + y])
    walls = np.concatenate([*lids, *sides, end])
    pad.felt.append((walls, np.tile(-UP, (len(walls), 1))))
    assert reach.go(se3.pose(down, [20.0, 0.0, 130.0]))
    assert np.allclose(pad.guard.world_from_sensor[:3, 3], [20.0, 0.0, 130.0], atol=0.1)


@pytest.mark.parametrize(
    ("leads", "found", "searches"), [((), None, 2), ((3,), 3, 4), ((1, 3), 1, 3), ((0, 1, 2, 3), 0, 1)]
)
def test_a_way_that_keeps_off_more_is_preferred_and_none_is_known_from_the_most_lenient(
    pad, monkeypatch, leads, found, searches
):
    reach, asked = Reach(pad), []
    reach._routes = (RoutesConfig(margin=3.0), RoutesConfig(margin=1.0))
    reach._suspect = np.array([[0.0, 0.0, 200.0]])

    def searched(tool, start, goal, places, ways, config, barred):
        number = 2 * (len(places) == 0) + (config.margin == 1.0)
        asked.append(number)
        return [np.full((4, 4), float(number))] if number in leads else None

    monkeypatch.setattr("exploration.planning.touching.reach.route", searched)
    poses = reach._routed(pad.guard.world_from_sensor, np.eye(4))
    assert (poses is None) == (found is None)
    assert found is None or poses[0][0, 0] == found
    assert len(asked) == searches
