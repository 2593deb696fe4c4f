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
