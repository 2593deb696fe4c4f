"""Positions between reports and a moment after the last."""

import numpy as np
import pytest

from exploration.devices.whereabouts import Whereabouts


@pytest.fixture
def moving():
    where = Whereabouts(2)
    for k in range(50):
        t = 1.0 + 0.004 * k
        where.note(t, np.array([20.0 * t, -3.0 * t]))
    return where


@pytest.mark.parametrize("moment", [1.0, 1.05, 1.1234, 1.196, 1.2, 1.21])
def test_a_steady_motion_is_told_at_any_time_between_and_just_after_reports(moving, moment):
    assert moving.at(moment) == pytest.approx([20.0 * moment, -3.0 * moment], abs=1e-9)


def test_long_after_the_last_report_no_further_motion_is_believed(moving):
    assert moving.at(9.0)[0] == pytest.approx(20.0 * (1.196 + 0.02))


def test_one_report_alone_stands_for_every_time():
    where = Whereabouts(1)
    assert not where.known
    where.note(5.0, np.array([7.0]))
    assert where.known
    assert [where.at(t)[0] for t in (4.0, 5.0, 6.0)] == [7.0, 7.0, 7.0]


@pytest.mark.parametrize("begins", [0.0, 0.004, 0.012, 0.02])
def test_a_stage_that_may_brake_is_surely_no_less_far_than_told(begins):
    """It runs at 40 mm/s and brakes at 2000 mm/s^2 from some time on; reports come every 4 ms."""
    speed, braking = 40.0, 2000.0

    def true(time: float) -> float:
        late = np.clip(time - begins, 0.0, speed / braking)
        return speed * min(time, begins) + speed * late - 0.5 * braking * late**2

    where = Whereabouts(1)
    for time in np.arange(-0.04, 0.0161, 0.004):
        where.note(float(time), np.array([true(time) if time > 0.0 else speed * time]))
    told = [float(where.surely_at(t, braking)[0]) for t in np.arange(0.016, 0.035, 0.001)]
    assert all(x <= true(t) + 1e-9 for x, t in zip(told, np.arange(0.016, 0.035, 0.001), strict=True))
    assert told[0] == pytest.approx(true(0.016))
    if begins > 0.016:
        assert told[3] > true(0.016) + 0.05
