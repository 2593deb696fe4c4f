"""What touching is said to take, against the clock of the simulated stage."""

import numpy as np
import pytest

from exploration.control.procedures.approach import retreat
from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.planning.touching.lone_touch import Approach, touch_once
from exploration.planning.touching.pace import Pace
from exploration.planning.ways.round_ball import Ball, way_round
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cube
from models.solid import Solid
from primitives.pose import frame_along, pose


def _guard() -> Guard:
    spec = load_sensor("lts210")
    above = pose(frame_along([0.0, 0.0, -1.0]), [0.0, 0.0, 100.0])
    stage, arrays = simulate(
        Solid.from_csg(Cube((40.0, 40.0, 40.0))), [spec], np.random.default_rng(0), start_pose=above
    )
    return Guard(stage, arrays, [Calibration.nominal(spec)])


def test_the_seconds_of_a_way_are_those_of_the_stage() -> None:
    guard, ball = _guard(), Ball(np.zeros(3), 60.0)
    goal = pose(frame_along([-1.0, 0.0, 0.0]), [90.0, 0.0, 5.0])
    way = way_round(guard.world_from_sensor, goal, ball)
    guard.hold()
    said, begun = Pace.of(guard).travel(guard.world_from_sensor, way), guard.cost.seconds
    for stop in way:
        guard.go_to(stop)
    assert said == pytest.approx(guard.cost.seconds - begun, rel=0.1)


@pytest.mark.parametrize("flown", [0.0, 50.0])
def test_the_seconds_of_a_touch_are_those_of_the_stage(flown: float) -> None:
    guard = _guard()
    start = guard.world_from_sensor
    approach, pace = Approach(start, 120.0, flown), Pace.of(guard)
    guard.hold()
    begun = guard.cost.seconds
    if flown:
        guard.go_to(approach.felt.start)
    assert touch_once(guard, approach.felt).met
    retreat(guard, 8.0)
    guard.go_to(start)
    ways = float(pace.approach(flown, 80.0 - flown)) + float(pace.back(80.0))
    lying = guard.cost.seconds - begun - ways
    assert 0.1 < lying < pace.settling  # a face straight ahead lets the pad lie sooner than most
