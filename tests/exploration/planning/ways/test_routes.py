"""Ways round what is known, and round where something unknown was in the way."""

import itertools

import numpy as np
import pytest

from exploration.planning.ways.routes import Tool, on_the_way, route
from primitives import pose as se3

DOWN = np.diag([1.0, -1.0, -1.0])
TOOL, NOTHING, WAYS = Tool.of_size((18.0, 28.0)), np.empty((0, 3)), np.eye(3)
START, GOAL = se3.pose(DOWN, [-60.0, 0.0, 0.0]), se3.pose(DOWN, [60.0, 0.0, 0.0])


def passed(start, poses):
    """(n, 3) places of the array on its way."""
    legs = itertools.pairwise([start, *poses])
    return np.concatenate([on_the_way(a, b, TOOL.mount, 1.0, 0.1)[:, :3, 3] for a, b in legs])


def test_a_way_keeps_off_a_pose_at_which_something_was_in_the_way():
    straight = passed(START, route(TOOL, START, GOAL, NOTHING, WAYS))
    met = se3.pose(DOWN, straight[len(straight) // 2])
    round_ = passed(START, route(TOOL, START, GOAL, NOTHING, WAYS, barred=[met]))
    assert np.linalg.norm(straight - met[:3, 3], axis=1).min() < 1.0
    assert np.linalg.norm(round_ - met[:3, 3], axis=1).min() > 3.0


def test_an_array_that_stands_where_it_was_stopped_may_leave():
    assert route(TOOL, START, GOAL, NOTHING, WAYS, barred=[START]) is not None


def test_a_flange_goes_straight_and_turns_evenly_whatever_it_carries_on_an_arm():
    rng = np.random.default_rng(4)
    for _ in range(20):
        a, b, mount = (
            se3.pose(se3.rotation_exp(rng.normal(size=3)), rng.normal(0.0, 60.0, 3)) for _ in range(3)
        )
        poses = on_the_way(a, b, mount, 5.0, 0.1)
        flange = poses @ se3.inverse(mount)
        assert poses[[0, -1]] == pytest.approx(np.stack([a, b]))
        assert np.diff(flange[:, :3, 3], n=2, axis=0) == pytest.approx(0.0, abs=1e-9)
        turns = se3.rotation_log(flange[1:, :3, :3] @ np.swapaxes(flange[:-1, :3, :3], 1, 2))
        assert turns == pytest.approx(np.broadcast_to(turns[0], turns.shape), abs=1e-9)
        assert np.linalg.norm(turns[0]) <= 0.1
