"""A trail leads back over every place that was passed, in ever longer ways."""

import numpy as np
import pytest

from exploration.planning.known.trail import Trail
from primitives import pose as se3

X = np.array([1.0, 0.0, 0.0])


def walked(count, step):
    trail = Trail()
    for k in range(count):
        trail.pass_through(se3.pose(translation=k * step * X))
    return trail


def test_ways_back_begin_at_the_end_and_double():
    trail = walked(20, 10.0)
    ways = [[float(stop[0, 3]) for stop in stops] for stops in trail.back()]
    assert [len(way) for way in ways] == [1, 2, 4, 8, 16, 20]
    assert all(way == [190.0 - 10.0 * k for k in range(len(way))] for way in ways)
    assert trail.start[0, 3] == 0.0


@pytest.mark.parametrize("length", [0, 1, 7, 20])
def test_the_way_back_to_an_earlier_moment_ends_where_the_trail_did_then(length):
    trail = walked(length, 10.0)
    for k in range(length, 20):
        trail.pass_through(se3.pose(translation=k * 10.0 * X))
    stops = [float(stop[0, 3]) for stop in trail.since(length)]
    assert stops == [10.0 * k for k in range(19, length - 1, -1)]
    assert trail.length == 20


def test_small_steps_are_not_kept_and_turns_are():
    assert len(list(walked(50, 0.1).back())) == 0
    trail = Trail()
    for angle in np.linspace(0.0, np.pi, 30):
        trail.pass_through(se3.pose(se3.rotation_exp(angle * X)))
    assert len(max(trail.back(), key=len)) > 8


def test_a_trail_that_nobody_walked_has_no_start():
    assert Trail().start is None
    assert list(Trail().back()) == []


def test_what_lies_past_a_fault_that_was_backed_off_from_is_forgotten():
    trail = walked(30, 10.0)
    trail.rejoin(se3.pose(translation=[153.0, 4.0, 0.0]))
    assert trail.length == 16
    assert trail.since(0)[0][0, 3] == 150.0
