import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from exploration.devices.protocols import StageLimits
from exploration.devices.simulated_stage import PoseNoise, SimulatedStage
from exploration.devices.stage_trail import StageTrail
from primitives.errors import PalpateError
from primitives.pose import inverse, pose, random_rotation, rotation_exp, rotation_log

LIMITS = StageLimits(100.0, 1000.0, 1.5, 20.0)


def watched(stage, seconds, dt=0.001):
    """True poses every `dt` while the stage runs on."""
    found = [stage._true]
    for _ in range(round(seconds / dt)):
        stage._advance(stage._time + dt)
        found.append(stage._true)
    return np.array(found)


def speeds(poses, dt=0.001):
    linear = np.diff(poses[:, :3, 3], axis=0) / dt
    angular = rotation_log(poses[1:, :3, :3] @ np.swapaxes(poses[:-1, :3, :3], -1, -2)) / dt
    return linear, angular


def within_limits(poses, dt=0.001):
    for velocity, speed, acceleration in zip(
        speeds(poses),
        (LIMITS.speed, LIMITS.turn_speed),
        (LIMITS.acceleration, LIMITS.turn_acceleration),
        strict=True,
    ):
        assert np.linalg.norm(velocity, axis=1).max() <= speed * 1.001
        assert np.linalg.norm(np.diff(velocity, axis=0), axis=1).max() / dt <= acceleration * 1.02


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10_000))
def test_no_command_drives_the_stage_beyond_its_limits(seed):
    rng = np.random.default_rng(seed)
    stage = SimulatedStage(pose(random_rotation(rng)), rng, LIMITS)
    poses = []
    for _ in range(6):
        match rng.integers(3):
            case 0:
                stage.move(rng.normal(size=6) * [300, 300, 300, 4, 4, 4])
            case 1:
                stage.go_to(pose(random_rotation(rng), rng.uniform(-50, 50, 3)))
            case _:
                stage.stop()
        poses.append(watched(stage, float(rng.choice([0.02, 0.1, 0.5])))[1:])
    within_limits(np.concatenate(poses))


def test_go_to_arrives_straight_and_at_rest():
    stage = SimulatedStage(np.eye(4), np.random.default_rng(0), LIMITS)
    goal = pose(rotation_exp([0.3, -0.8, 0.2]), [30.0, 40.0, 0.0])
    stage.go_to(goal)
    assert stage.moving
    poses = watched(stage, 1.5)
    assert not stage.moving
    assert stage.pose() == pytest.approx(goal, abs=1e-9)
    across = np.cross(poses[:, :3, 3], [0.6, 0.8, 0.0])
    assert np.abs(across).max() < 1e-9
    took = np.argmax(np.abs(poses - goal).max(axis=(1, 2)) < 1e-9) * 0.001
    angle = np.linalg.norm([0.3, -0.8, 0.2])
    speed, acceleration = min(100.0 / 50.0, 1.5 / angle), min(1000.0 / 50.0, 20.0 / angle)
    assert took == pytest.approx(1 / speed + speed / acceleration, abs=0.002)


def test_twist_is_followed_in_the_flange_frame():
    stage = SimulatedStage(pose(rotation_exp([0, np.pi / 2, 0])), np.random.default_rng(0), LIMITS)
    stage.move(np.array([0.0, 0.0, 10.0, 0.0, 0.0, 0.0]))
    stage._advance(1.0)
    assert stage.pose()[:3, 3] == pytest.approx([9.95, 0.0, 0.0], abs=0.01)


def test_stop_takes_no_longer_than_the_limit_allows():
    stage = SimulatedStage(np.eye(4), np.random.default_rng(0), LIMITS)
    stage.move(np.array([80.0, 0, 0, 0, 0, 0]))
    stage._advance(0.5)
    stage.stop()
    stage._advance(0.5 + 0.081)
    here = stage.pose()
    stage._advance(1.0)
    assert stage.pose() == pytest.approx(here)


def test_latency_delays_a_command():
    stage = SimulatedStage(np.eye(4), np.random.default_rng(0), LIMITS, latency=0.02)
    stage.move(np.array([50.0, 0, 0, 0, 0, 0]))
    stage._advance(0.02)
    assert stage.pose()[0, 3] == 0.0
    stage._advance(0.05)
    assert stage.pose()[0, 3] > 0.1


def test_encoder_noise_is_white_per_reading_and_constant_per_contact():
    stage = SimulatedStage(np.eye(4), np.random.default_rng(0), noise=PoseNoise(white=0.1, contact=1.0))
    stage._touch()
    readings = np.array([stage.pose()[:3, 3] for _ in range(500)])
    bias = readings.mean(axis=0)
    assert (readings - bias).std() == pytest.approx(0.1, rel=0.1)
    stage._touch()
    other = np.array([stage.pose()[:3, 3] for _ in range(500)]).mean(axis=0)
    assert np.linalg.norm(other - bias) > 0.1


def test_reads_back_where_rows_were_sampled():
    stage = SimulatedStage(np.eye(4), np.random.default_rng(0), LIMITS)
    stage.move(np.array([50.0, 0, 0, 0, 0, 1.0]))
    stage._advance(0.5)
    before, when, mount = stage._true, np.array([0.5, 0.505]), pose(None, [0.0, 0.0, 7.0])
    stage._advance(0.51)
    then, later = stage._trail.at(when, mount)
    assert then == pytest.approx(before @ mount)
    moved = inverse(then) @ later
    assert moved[0, 3] == pytest.approx(0.25, rel=0.01)
    assert rotation_log(moved[:3, :3]) == pytest.approx([0.0, 0.0, 0.005], rel=1e-3, abs=1e-9)


def test_the_way_between_two_steps_is_a_straight_line_and_an_even_turn():
    turn, line = np.array([0.02, -0.05, 0.03]), np.array([1.0, 2.0, -0.5])
    first = pose(random_rotation(np.random.default_rng(4)), [5.0, 6.0, 7.0])
    last = pose(first[:3, :3] @ rotation_exp(turn), first[:3, 3] + line)
    trail = StageTrail(0.0, first)
    trail.add(1.0, last)
    for share, found in zip((0.0, 0.3, 1.0), trail.at(np.array([0.0, 0.3, 1.0]), np.eye(4)), strict=True):
        expected = pose(first[:3, :3] @ rotation_exp(share * turn), first[:3, 3] + share * line)
        assert found == pytest.approx(expected, abs=1e-12)


def test_a_trail_remembers_however_long_it_runs():
    trail = StageTrail(0.0, np.eye(4))
    for k in range(1, 1001):
        trail.add(0.01 * k, pose(None, [float(k), 0.0, 0.0]))
    assert trail.at(np.array([9.945]), np.eye(4))[0, 0, 3] == pytest.approx(994.5)


@pytest.mark.parametrize("twist", [np.full(6, np.nan), np.zeros(3)])
def test_broken_commands_are_refused(twist):
    stage = SimulatedStage(np.eye(4), np.random.default_rng(0))
    with pytest.raises(PalpateError):
        stage.move(twist)
