"""The ends of a loop's run of ticks are run on by its own other end."""

import numpy as np
import pytest

from exploration.control.edge_ticks import EdgeTick
from exploration.control.run_on import ON, leading_from, leading_to
from exploration.sensing.lines.followed import Followed
from primitives.pose import pose

RADIUS = 20.0  # [mm]


def tick(point, angle):
    """The edge through a point, running at an angle."""
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]]
    )
    edge = Followed(np.zeros(6), np.eye(6), 1, 1.0, np.full(5, np.inf), np.zeros(3), True)
    return EdgeTick(edge, None, pose(turn, [*point, 0.0]), 1.0)


@pytest.fixture
def loop():
    """Once round a circle and 5 mm on."""
    turned = np.arange(0.0, 2.0 * np.pi + 5.0 / RADIUS, 0.01)
    return [tick(RADIUS * np.array([np.cos(t), np.sin(t)]), t + 0.5 * np.pi) for t in turned]


def arc(ticks):
    """(n,) [rad] of the ticks round the circle."""
    return np.array([np.arctan2(*t.point[[1, 0]]) for t in ticks])


def test_what_leads_to_a_loops_start_is_its_last_stretch_before_it(loop):
    before = arc(leading_to(loop, loop[0]))
    assert before.max() == pytest.approx(0.0, abs=0.012)
    assert before.min() == pytest.approx(-ON / RADIUS, abs=0.012)
    assert (np.diff(before) > 0.0).all()


def test_what_leads_from_a_loops_end_is_its_first_stretch_after_it(loop):
    after = arc(leading_from(loop, loop[-1])) * RADIUS
    assert after.min() == pytest.approx(5.0, abs=0.3)
    assert after.max() == pytest.approx(5.0 + ON, abs=0.3)


def test_an_edge_that_does_not_come_round_is_not_run_on(loop):
    half = loop[: len(loop) // 2]
    assert leading_to(half, half[0]) == []
    assert leading_from(half, half[-1]) == []
    assert leading_to([], half[0]) == []
