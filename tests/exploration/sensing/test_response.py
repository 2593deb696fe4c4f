import numpy as np
import pytest
from scipy.special import erf

from exploration.sensing.response import CELLS, REACH, Response, look_up, rubber


def test_narrow_taxels_see_the_error_function():
    response = rubber(1.8, (0.01, 0.01))
    d = np.linspace(-6.0, 6.0, 41)
    expected = 0.5 * (1 + erf(d / (np.sqrt(2) * 1.8)))
    assert response.edge(d, response.width([1.0, 0.0])) == pytest.approx(expected, abs=1e-5)


def test_taxels_twice_as_wide_as_the_blur_are_integrated_to_a_thousandth():
    spread, pitch = 1.7, 3.4
    response = rubber(spread, (pitch, pitch))
    d = np.linspace(-8.0, 8.0, 33)
    s = np.linspace(-pitch / 2, pitch / 2, 2001)
    exact = (0.5 * (1 + erf((d[:, None] + s) / (np.sqrt(2) * spread)))).mean(axis=1)
    assert response.edge(d, response.width([1.0, 0.0])) == pytest.approx(exact, abs=1e-3)


@pytest.mark.parametrize("order", [0, 1])
def test_each_table_is_the_integral_of_the_one_before(order):
    table = rubber(1.8, (1.8, 1.8)).table
    h = 1e-2
    for u in np.linspace(-4.0, 4.0, 17):
        low, mid, high = (np.array(look_up(table, u + e, order)) for e in (-h, 0.0, h))
        assert (high - low)[1:] / (2 * h) == pytest.approx(mid[:2], abs=2e-4)


def test_a_sampled_line_spread_gives_back_the_same_response():
    rubbery = rubber(1.8, (1.8, 1.8))
    sampled = Response.of_line_spread(rubbery.table[:, 0], rubbery.variance)
    assert len(sampled.table) == CELLS + 1
    assert np.abs(sampled.table - rubbery.table).max() < 1e-4
    assert look_up(sampled.table, 2 * REACH, 0)[2] == 2 * REACH
