"""Intervals against what is known of them."""

import numpy as np
import pytest
from scipy.stats import binomtest, ttest_1samp

from recognition.experiments.statistics import mean_of_units, median, share


@pytest.mark.parametrize(("right", "count"), [(0, 5), (5, 5), (7, 20), (199, 200)])
def test_shares_have_the_interval_that_scipy_gives_them(right, count):
    ours = share([True] * right + [False] * (count - right))
    theirs = binomtest(right, count).proportion_ci(method="wilson")
    assert (ours.low, ours.high) == pytest.approx((theirs.low, theirs.high), abs=1e-12)


def test_the_interval_of_a_median_holds_it_as_often_as_it_says():
    rng = np.random.default_rng(0)
    found = [median(rng.exponential(size=40)) for _ in range(200)]
    held = np.mean([e.low <= np.log(2) <= e.high for e in found])
    assert 0.88 <= held <= 0.99


def test_trials_of_one_part_that_agree_count_as_one():
    units = [part for part in range(10) for _ in range(20)]
    right = [part < 7 for part in units]
    ours, theirs = share(right, units), binomtest(7, 10).proportion_ci(method="wilson")
    assert (ours.low, ours.high) == pytest.approx((theirs.low, theirs.high), abs=0.03)
    assert share(right).high - share(right).low < 0.5 * (ours.high - ours.low)
    perfect = share([True] * 200, units)
    assert perfect.low == pytest.approx(binomtest(10, 10).proportion_ci(method="wilson").low)


@pytest.mark.parametrize("spread", [0.0, 0.3])
def test_the_interval_of_a_share_over_parts_holds_it(spread):
    """Each part has its own chance, and the interval is for the chance of parts like them."""
    rng = np.random.default_rng(1)
    held = 0
    for _ in range(200):
        chances = np.clip(rng.normal(0.6, spread, 24), 0, 1) if spread else np.full(24, 0.6)
        units = np.repeat(np.arange(24), 10)
        found = share(list(rng.random(240) < chances[units]), units.tolist())
        held += found.low <= (0.6 if not spread else 0.586) <= found.high
    assert held >= 178


def test_the_mean_of_units_has_students_interval():
    rng = np.random.default_rng(2)
    values = rng.normal(1.0, 2.0, 9)
    ours, theirs = mean_of_units(values), ttest_1samp(values, 0.0).confidence_interval()
    assert (ours.low, ours.high) == pytest.approx((theirs.low, theirs.high))
    twice = mean_of_units(np.repeat(values, 5), [k for k in range(9) for _ in range(5)])
    assert (twice.low, twice.high) == pytest.approx((ours.low, ours.high))


def test_nothing_has_no_interval_and_one_has_none_either():
    assert share([]) is None
    assert median([]) is None
    assert mean_of_units([]) is None
    assert mean_of_units([3.0]).low is None
    assert median([3.0, 4.0], ["a", "a"]).low is None
