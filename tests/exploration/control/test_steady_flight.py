"""Straight flights where nobody has been: on the line, at the speed told, stopped by what is met."""

from collections.abc import Callable

import numpy as np
import pytest

from exploration.control.procedures.approach import felt_speed, touched
from exploration.control.steady_flight import FlightConfig, fly
from exploration.devices.guard import Guard, Observation
from exploration.devices.protocols import StageLimits
from exploration.devices.simulated import simulate
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cube
from models.solid import Solid
from primitives import pose as se3
from primitives.arrays import Floats

Over = Callable[..., tuple[Guard, Solid]]
DOWN = np.diag([1.0, -1.0, -1.0])


def nothing(_: Observation) -> bool:
    return False


def flown(guard: Guard, goal: Floats) -> tuple[Floats, Floats]:
    """(n, 4, 4) poses of the flange on the way, and (n,) times."""
    seen: list[tuple[Floats, float]] = []
    off = se3.inverse(guard.sensor.flange_from_sensor)
    guard.observers = (lambda frame: seen.append((frame.world_from_sensor @ off, frame.time)),)
    assert fly(guard, goal, nothing) is None
    poses, times = zip(*seen, strict=True)
    return np.array(poses), np.array(times)


@pytest.mark.parametrize("turn", [0.0, 0.4, 2.5])
def test_a_flight_ends_where_it_was_told_on_a_straight_line(over: Over, turn: float) -> None:
    start = se3.pose(DOWN, [0.0, 0.0, 150.0])
    guard, _ = over(Cube((10.0, 10.0, 10.0)), start)
    goal = se3.pose(se3.rotation_exp(np.array([turn, 0.0, 0.0])) @ DOWN, [90.0, 30.0, 190.0])
    poses, _ = flown(guard, goal)
    assert np.allclose(guard.world_from_sensor, goal, atol=1e-3)
    line = poses[-1, :3, 3] - poses[0, :3, 3]
    aside = np.cross(poses[:, :3, 3] - poses[0, :3, 3], line / np.linalg.norm(line))
    assert np.linalg.norm(aside, axis=1).max() < 0.5


def test_neither_speed_nor_turning_passes_what_is_told(over: Over) -> None:
    config = FlightConfig()
    guard, _ = over(Cube((10.0, 10.0, 10.0)), se3.pose(DOWN, [0.0, 0.0, 150.0]))
    poses, times = flown(
        guard, se3.pose(se3.rotation_exp(np.array([0.0, 0.0, 3.0])) @ DOWN, [200.0, 0.0, 150.0])
    )
    step = np.diff(times)
    speed = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1) / step
    turned = np.array(
        [
            np.linalg.norm(se3.rotation_log(b @ a.T))
            for a, b in zip(poses[:-1, :3, :3], poses[1:, :3, :3], strict=True)
        ]
    )
    assert speed.max() < 1.02 * config.speed
    assert (turned / step).max() < 1.02 * config.turn
    assert (
        max(np.median(speed) / config.speed, np.median(turned / step) / config.turn) > 0.95
    )  # and no slower


def test_a_skin_that_meets_something_on_a_flight_is_stopped_within_its_depth(over: Over) -> None:
    guard, _ = over(Cube((40.0, 40.0, 40.0)), se3.pose(DOWN, [0.0, 0.0, 90.0]))
    met = fly(guard, se3.pose(DOWN, [0.0, 0.0, 0.0]), lambda seen: touched(seen.image))
    assert met is not None
    assert 17.0 < guard.world_from_sensor[2, 3] < 20.5


@pytest.mark.parametrize("toward", [True, False])
def test_the_skin_leads_no_faster_than_it_can_be_stopped(over: Over, toward: bool) -> None:
    guard, _ = over(Cube((10.0, 10.0, 10.0)), se3.pose(DOWN, [60.0, 0.0, 90.0 if toward else 0.0]))
    poses, times = flown(guard, se3.pose(DOWN, [60.0, 0.0, 0.0 if toward else 90.0]))
    speed = np.abs(np.diff(poses[:, 2, 3])) / np.diff(times)
    assert np.median(speed) == pytest.approx(felt_speed(guard, 50.0) if toward else 75.0, rel=0.05)


def test_on_a_slower_stage_line_and_turn_end_together_all_the_same() -> None:
    solid, spec = Solid.from_csg(Cube((10.0, 10.0, 10.0))), load_sensor("lts210")
    slow = StageLimits(speed=50.0, turn_speed=1.0)
    start = se3.pose(DOWN, [0.0, 0.0, 150.0])
    stage, arrays = simulate(solid, [spec], np.random.default_rng(0), start_pose=start, limits=slow)
    guard = Guard(stage, arrays, [Calibration.nominal(spec)])
    poses, _ = flown(guard, se3.pose(se3.rotation_exp(np.array([1.5, 0.0, 0.0])) @ DOWN, [100.0, 0.0, 180.0]))
    gone = np.linalg.norm(poses[:, :3, 3] - poses[0, :3, 3], axis=1) / np.linalg.norm([100.0, 30.0])
    turned = np.array([se3.turn_between(poses[0], pose) for pose in poses]) / 1.5
    assert np.abs(gone - turned).max() < 0.02


def test_a_goal_that_is_never_come_nearer_to_is_left_to_the_stage(over: Over) -> None:
    guard, _ = over(Cube((10.0, 10.0, 10.0)), se3.pose(DOWN, [0.0, 0.0, 150.0]))
    asked: list[Floats] = []
    guard.move = lambda twist: guard.observe()  # type: ignore[method-assign]  # axes that take no such twist
    guard.go_to = lambda pose, until=None: asked.append(pose)  # type: ignore[method-assign, assignment]
    goal = se3.pose(se3.rotation_exp(np.array([0.5, 0.0, 0.0])) @ DOWN, [0.0, 0.0, 150.0])
    assert fly(guard, goal, nothing) is None
    assert len(asked) == 1
