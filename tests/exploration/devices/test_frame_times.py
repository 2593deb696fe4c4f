"""Stamps of frames that were held up on their way, against the times at which they were complete."""

import numpy as np
import pytest

from exploration.devices.frame_times import FrameTimes

LATENCY = 0.002
SETTLED = 200  # frames


def stamped(true, nominal, lost=0.0, counted=False, broken=False, frames=3000):
    """(n,) stamps less the times [s] of frames that come late and in bunches, and the raw delays beside them."""
    rng, times = np.random.default_rng(1), FrameTimes(nominal)
    off, raw, busy, missing, last = [], [], 0.0, 0, -np.inf
    for k in range(frames):
        if k > SETTLED and rng.random() < lost:
            missing += 1
            continue
        if rng.random() < 0.03:
            busy = k * true + rng.uniform(0.0, 0.03)
        heard = max(k * true + LATENCY + rng.exponential(0.001), busy)
        stamp = times.stamp(heard, missing if counted else 0, broken and missing > 0)
        assert last < stamp < heard + 0.003
        off.append(stamp - k * true - LATENCY)
        raw.append(heard - k * true - LATENCY)
        missing, last = 0, stamp
    return np.array(off[SETTLED:]), np.array(raw[SETTLED:])


@pytest.mark.parametrize(
    ("true", "nominal"), [(0.005, 0.005), (0.0051, 0.005), (0.006, 0.005), (1 / 30, 0.033)]
)
def test_what_holds_frames_up_is_taken_from_their_times(true, nominal):
    off, raw = stamped(true, nominal)
    assert np.quantile(raw, 0.99) > 0.01
    assert np.abs(off).max() < 0.0006


def test_lost_frames_that_the_array_counts_move_nothing():
    assert np.abs(stamped(0.005, 0.005, lost=0.01, counted=True)[0]).max() < 0.0006


def test_lost_frames_that_left_their_bytes_are_made_out():
    assert np.quantile(np.abs(stamped(0.005, 0.005, lost=0.01, broken=True)[0]), 0.8) < 0.001


def test_a_frame_lost_in_silence_is_made_out_within_a_fraction_of_a_second():
    times = FrameTimes(0.005)
    late = [times.stamp(0.005 * k) - 0.005 * k for k in range(1000) if k != 500]
    assert min(late) == pytest.approx(-0.005, abs=1e-4)
    assert np.abs(late[:500] + late[560:]).max() < 1e-6


def test_many_frames_lost_while_nobody_listened_are_made_out_at_once():
    times, sent = FrameTimes(0.005), [*range(500), *range(700, 1300)]
    late = [times.stamp(max(0.005 * k, 4.0 * (700 <= k < 800))) - 0.005 * k for k in sent]
    assert np.abs(late[:500]).max() < 1e-6
    assert np.abs(late[620:]).max() < 0.003


def test_after_a_pause_the_next_frame_is_its_own_beginning():
    times = FrameTimes(0.005)
    for k in range(300):
        times.stamp(0.005 * k)
    assert times.stamp(10.0) == 10.0
