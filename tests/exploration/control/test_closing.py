"""Coming round: past the start, or past a second one where the first was taken in a corner."""

import numpy as np
import pytest

from exploration.control.closing import ClosingConfig, Home, came_round, comes_by
from exploration.control.edge_ticks import EdgeTick
from exploration.sensing.lines.followed import Followed
from primitives.pose import frame_along, pose

STEP = 0.1  # [mm] a tick


def ring(radius: float, laps: float, first_tangent=None):
    """Ticks on a circle about the origin, and the tick 12 mm on; the first looks another way if told."""
    edge = Followed(np.zeros(6), np.eye(6), 1, 1.0, np.full(5, np.inf), np.zeros(3), True)
    ticks = []
    for a in np.arange(0.0, 2 * np.pi * laps, STEP / radius):
        along = [-np.sin(a), np.cos(a), 0.0]
        if not ticks and first_tangent is not None:
            along = first_tangent
        turn = frame_along([0.0, 0.0, 1.0], along)
        ticks.append(EdgeTick(edge, None, pose(turn, radius * np.array([np.cos(a), np.sin(a), 0.0])), 1.0))
    return ticks, round(ClosingConfig().second / STEP)


@pytest.mark.parametrize("radius", [8.0, 20.0, 60.0])
def test_a_ring_closes_a_little_past_its_start_and_not_before(radius: float) -> None:
    ticks, second = ring(radius, 1.3)
    closed = [
        n
        for n in range(second, len(ticks))
        if came_round(ticks[: n + 1], second, n * STEP, ClosingConfig()) == 0
    ]
    past = closed[0] * STEP - 2 * np.pi * radius
    assert 2.5 < past < 4.5


def test_a_start_that_looked_another_way_is_made_up_for_by_the_second() -> None:
    ticks, second = ring(20.0, 1.5, first_tangent=[1.0, 0.0, 0.0])
    found = [came_round(ticks[: n + 1], second, n * STEP, ClosingConfig()) for n in range(second, len(ticks))]
    assert 0 not in found
    assert second in found
    assert found.index(second) * STEP > 2 * np.pi * 20.0


def test_an_edge_that_runs_by_the_other_way_is_not_come_round() -> None:
    ticks, _ = ring(20.0, 0.1)
    home = Home(ticks[0].point, -ticks[0].tangent)
    assert all(comes_by([home], tick, 0.0, ClosingConfig()) is None for tick in ticks)


def test_it_is_told_which_of_several_places_the_edge_comes_by_and_not_before_it_may() -> None:
    ticks, _ = ring(20.0, 0.2)
    elsewhere = Home(np.array([90.0, 0.0, 0.0]), ticks[0].tangent)
    for after, told in ((0.0, {None, 1}), (3.0, {None, 1}), (99.0, {None})):
        homes = [elsewhere, Home(ticks[0].point, ticks[0].tangent, after)]
        found = [comes_by(homes, tick, n * STEP, ClosingConfig()) for n, tick in enumerate(ticks)]
        assert set(found) == told
