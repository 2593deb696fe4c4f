"""Smoothing splines: scipy's as the oracle, and the two ends of stiffness."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, make_smoothing_spline

from exploration.control.smoothing_spline import Readings, in_order, travel_along


@pytest.fixture
def readings():
    rng = np.random.default_rng(3)
    places = np.cumsum(rng.uniform(0.02, 0.3, 120))
    columns = np.stack([np.sin(places / 3.0), 0.2 * places, np.cos(places)], axis=1)
    return Readings(places, columns + 0.03 * rng.standard_normal(columns.shape), rng.uniform(0.5, 2.0, 120))


@pytest.mark.parametrize("stiffness", [1e-2, 1.0, 1e3])
def test_a_smoothing_spline_is_the_one_that_scipy_finds(readings, stiffness):
    at = np.linspace(readings.places[0], readings.places[-1], 500)
    ours = readings.smoothed(stiffness)
    for order in (0, 1):
        theirs = [
            make_smoothing_spline(readings.places, column, readings.weights, stiffness)(at, order)
            for column in readings.columns.T
        ]
        np.testing.assert_allclose(ours.at(at, order), np.stack(theirs, axis=1), atol=1e-7)


def test_without_stiffness_it_runs_through_every_reading(readings):
    natural = CubicSpline(readings.places, readings.columns, bc_type="natural")
    at = np.linspace(readings.places[0], readings.places[-1], 500)
    np.testing.assert_allclose(readings.smoothed(0.0).at(at), natural(at), atol=1e-9)


def test_it_stiffens_to_the_least_squares_line(readings):
    at = np.linspace(readings.places[0] - 1.0, readings.places[-1] + 1.0, 50)
    line = np.polyfit(readings.places, readings.columns, 1, w=np.sqrt(readings.weights))
    np.testing.assert_allclose(readings.smoothed(np.inf).at(at), np.outer(at, line[0]) + line[1], atol=1e-12)
    np.testing.assert_allclose(readings.smoothed(1e9).at(at), readings.smoothed(np.inf).at(at), atol=1e-4)


def test_beyond_its_ends_it_runs_on_straight(readings):
    spline = readings.smoothed(1.0)
    end, slope = spline.at(readings.places[-1:])[0], spline.at(readings.places[-1:], 1)[0]
    np.testing.assert_allclose(spline.at(readings.places[-1:] + 2.0)[0], end + 2.0 * slope, atol=1e-12)


@pytest.mark.parametrize("stiffness", [1e-2, 10.0, np.inf])
def test_what_it_misses_is_what_the_halves_do_not_predict(readings, stiffness):
    total = 0.0
    for first in (0, 1):
        used, held = slice(first, None, 2), slice(first + 1, -1, 2)
        half = Readings(readings.places[used], readings.columns[used], readings.weights[used])
        off = half.smoothed(stiffness).at(readings.places[held]) - readings.columns[held]
        total += float(np.sum(readings.weights[held, None] * off**2))
    assert readings.missed(stiffness) == pytest.approx(total, rel=1e-9)


def test_noise_across_a_way_does_not_lengthen_it():
    rng = np.random.default_rng(0)
    points = np.linspace(0.0, 50.0, 500)[:, None] * np.array([1.0, 0.0, 0.0])
    points[:, 1:] += rng.normal(0.0, 0.2, (500, 2))
    tangents = np.tile([1.0, 0.0, 0.0], (500, 1))
    assert travel_along(points, tangents)[-1] == pytest.approx(50.0)


def test_readings_in_order_increase_and_keep_their_means():
    places = np.random.default_rng(1).permutation(np.repeat(np.arange(100.0), 2))
    s, column = in_order(places, 50, 2.0 * places)
    assert len(s) <= 50
    assert (np.diff(s) > 0.0).all()
    np.testing.assert_allclose(column, 2.0 * s)
