"""Intervals against what is known of them."""

import numpy as np
import pytest
from scipy.stats import binomtest

from recognition.experiments.statistics import median, wilson


@pytest.mark.parametrize(("right", "count"), [(0, 5), (5, 5), (7, 20), (199, 200)])
def test_shares_have_the_interval_that_scipy_gives_them(right, count):
    ours, theirs = wilson(right, count), binomtest(right, count).proportion_ci(method="wilson")
    assert (ours.low, ours.high) == pytest.approx((theirs.low, theirs.high), abs=1e-12)


def test_the_interval_of_a_median_holds_it_as_often_as_it_says():
    rng = np.random.default_rng(0)
    found = [median(rng.exponential(size=40)) for _ in range(200)]
    held = np.mean([e.low <= np.log(2) <= e.high for e in found])
    assert 0.88 <= held <= 0.99


def test_nothing_has_no_interval():
    assert wilson(0, 0) is None
    assert median([]) is None
