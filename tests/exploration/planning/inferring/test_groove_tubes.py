"""The circle across a groove, from contacts on its bottom or its sides."""

import numpy as np
import pytest

from exploration.planning.inferring.groove_tubes import tube_felt

LOW, HIGH, RADIUS = -6.0, 6.0, 7.0
OVER = np.sqrt(RADIUS**2 - HIGH**2)  # of the circle's center, over the wall
DEPTH = RADIUS - OVER


def on_it(at):
    """Depths and leans of contacts at heights along the axis."""
    at = np.asarray(at)
    return at, np.sqrt(RADIUS**2 - at**2) - OVER, -at / RADIUS


@pytest.mark.parametrize(
    "at",
    [
        np.linspace(-2.0, 2.5, 5),  # on its bottom
        np.full(4, 4.0),  # at one place of its side
        np.array([3.8, 4.1, 4.4, -4.0]),  # on both sides
    ],
)
def test_what_was_felt_of_a_round_groove_tells_how_deep_it_is(at):
    tube = tube_felt(*on_it(at), LOW, HIGH)
    assert tube.depth == pytest.approx(DEPTH, abs=0.02)
    assert tube.radius == pytest.approx(RADIUS, abs=0.02)
    assert tube.height == pytest.approx(0.0, abs=1e-9)


def test_a_flat_bottom_and_a_slope_that_is_no_circle_are_none():
    at, depths, leans = on_it(np.full(4, 4.0))
    assert tube_felt(at, depths, 0.0 * leans, LOW, HIGH) is None
    assert tube_felt(at, depths, -leans, LOW, HIGH) is None
    assert tube_felt(at, depths, leans + 0.3, LOW, HIGH) is None
    assert tube_felt(at[:2], depths[:2], leans[:2], LOW, HIGH) is None
    assert tube_felt(at, depths + 4.0, leans, LOW, HIGH) is None  # deeper than half round
    mixed = [np.concatenate([a, b]) for a, b in zip(on_it(np.full(3, 4.0)), on_it(np.zeros(3)), strict=True)]
    assert tube_felt(mixed[0], mixed[1], np.array([0.9, 0.9, 0.9, 0.0, 0.0, 0.0]), LOW, HIGH) is None
    assert tube_felt(at, 0.0 * depths, leans, LOW, HIGH) is None


@pytest.mark.parametrize("sides", [(1.0,), (1.0, -1.0)])
def test_straight_sides_of_a_groove_for_a_belt_are_no_circle(sides):
    at = np.concatenate([side * np.linspace(2.5, 5.5, 12) for side in sides])
    leans = -0.75 * np.sign(at) + np.random.default_rng(0).normal(scale=0.02, size=len(at))
    assert tube_felt(at, 1.13 * (6.0 - np.abs(at)), leans, LOW, HIGH) is None
    sides_of_a_circle = np.concatenate([side * np.linspace(3.0, 5.5, 12) for side in sides])
    assert tube_felt(*on_it(sides_of_a_circle), LOW, HIGH).depth == pytest.approx(DEPTH, abs=0.05)
