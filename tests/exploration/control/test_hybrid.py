"""Hybrid control: selection, anti-windup, and margins that a simulated loop bears out."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from exploration.control.hybrid import HybridGains, HybridState, hybrid, margins

PERIOD = 0.005


def run_loop(kp: float, latency: float, seconds: float = 3.0) -> np.ndarray:
    """The press error [mm] of a skin that integrates what was commanded `latency` and a period ago."""
    gains = HybridGains(press=kp, press_speed=np.inf)
    late = round(latency / PERIOD) + 1
    queue, depth, state, errors = [0.0] * late, 0.0, HybridState(), []
    for _ in range(round(seconds / PERIOD)):
        twist, state = hybrid(state, 1.0 - depth, np.zeros(2), np.zeros(2), np.zeros(6), PERIOD, gains)
        queue.append(float(twist[2]))
        depth += queue.pop(0) * PERIOD
        errors.append(1.0 - depth)
    return np.array(errors)


@pytest.mark.parametrize("latency", [0.0, 0.01, 0.02, 0.05])
def test_gains_for_a_delay_keep_forty_five_degrees_and_twice_the_gain(latency: float) -> None:
    gains = HybridGains.for_delay(PERIOD, latency)
    found = margins(gains.press, PERIOD, latency)
    assert found.phase > np.radians(45.0)
    assert found.gain > 2.0
    assert found.delay > latency / 2


@pytest.mark.parametrize("latency", [0.0, 0.02])
def test_the_loop_rings_just_above_its_gain_margin_and_not_below(latency: float) -> None:
    kp = HybridGains.for_delay(PERIOD, latency).press
    edge = kp * margins(kp, PERIOD, latency).gain
    calm, wild = run_loop(0.8 * edge, latency), run_loop(1.2 * edge, latency)
    assert np.abs(calm[-100:]).max() < np.abs(calm[:100]).max()
    assert np.abs(wild[-100:]).max() > 10.0 * np.abs(wild[:100]).max()


@pytest.mark.parametrize("latency", [0.0, 0.02])
def test_a_step_of_press_overshoots_little(latency: float) -> None:
    errors = run_loop(HybridGains.for_delay(PERIOD, latency).press, latency)
    assert errors.min() > -0.2
    assert abs(errors[-1]) < 0.02


def test_force_axes_obey_the_law_and_the_rest_the_wish() -> None:
    wish = np.array([20.0, -3.0, 0.0, 0.0, 0.0, 0.4])
    twist, _ = hybrid(HybridState(), 0.1, np.array([0.02, 0.0]), np.zeros(2), wish, PERIOD)
    assert twist[[0, 1, 5]] == pytest.approx(wish[[0, 1, 5]])
    assert twist[2] > 0.0
    assert twist[4] > 0.0
    assert twist[3] == 0.0


def test_levelling_leaves_its_pivot_at_rest() -> None:
    pivot = np.array([4.0, -2.0])
    twist, _ = hybrid(HybridState(), 0.0, np.array([0.05, 0.03]), pivot, np.zeros(6), PERIOD)
    lift = twist[2] + twist[3] * pivot[1] - twist[4] * pivot[0]
    assert lift == pytest.approx(0.0, abs=1e-12)


def test_the_integral_stands_still_at_the_bound() -> None:
    state = HybridState()
    for _ in range(2000):
        _, state = hybrid(state, 5.0, np.zeros(2), np.zeros(2), np.zeros(6), PERIOD)
    assert state.integral[0] < 0.1


def test_the_integral_takes_away_a_steady_drift() -> None:
    gains, depth, state = HybridGains(), 0.0, HybridState()
    for _ in range(2000):
        twist, state = hybrid(state, 1.0 - depth, np.zeros(2), np.zeros(2), np.zeros(6), PERIOD, gains)
        depth += (float(twist[2]) - 2.0) * PERIOD
    assert abs(1.0 - depth) < 1e-3


small = st.floats(-0.5, 0.5)


@settings(deadline=None)
@given(small, small, st.floats(-10.0, 10.0), st.floats(-10.0, 10.0))
def test_tilting_lowers_the_slope_and_leaves_the_pivot_at_rest(gx, gy, cx, cy) -> None:
    slope, pivot = np.array([gx, gy]), np.array([cx, cy])
    (vx, vy, vz, wx, wy, _), _ = hybrid(HybridState(), 0.0, slope, pivot, np.zeros(6), PERIOD)
    change = np.array([-wy, wx])  # of the slope, by turning the pad
    assert change @ slope <= 0.0
    assert abs(vz + wx * cy - wy * cx) < 1e-9
    assert (vx, vy) == (0.0, 0.0)


@settings(deadline=None)
@given(st.floats(-3.0, 3.0), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
def test_commands_stay_within_their_bounds(missing, gx, gy) -> None:
    gains = HybridGains()
    twist, _ = hybrid(HybridState(), missing, np.array([gx, gy]), np.zeros(2), np.zeros(6), PERIOD, gains)
    assert abs(twist[2]) <= gains.press_speed + 1e-9
    assert np.abs(twist[3:5]).max() <= gains.level_speed + 1e-9
