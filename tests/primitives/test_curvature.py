import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from primitives.curvature import ORDERS, from_four, name_order, normal_curvature
from primitives.shapes import Cylinder

DIRECTIONS = np.deg2rad([0, 45, 90, 135])


def readings(k1, k2, theta, sigma=0.0, n=1, rng=None):
    exact = k1 * np.cos(DIRECTIONS - theta) ** 2 + k2 * np.sin(DIRECTIONS - theta) ** 2
    noise = 0.0 if rng is None else sigma * rng.standard_normal((n, 4))
    return (exact + noise + np.zeros((n, 4))).T


@given(st.floats(-0.2, 0.2), st.floats(0.001, 0.2), st.floats(-1.5, 1.5))
def test_four_directions_give_back_the_principal_curvatures(k2, difference, theta):
    found = from_four(*readings(k2 + difference, k2, theta), 0.001)
    assert found.k1[0] == pytest.approx(k2 + difference, abs=1e-12)
    assert found.k2[0] == pytest.approx(k2, abs=1e-12)
    assert np.cos(2 * (found.theta[0] - theta)) == pytest.approx(1.0)
    assert found.redundancy[0] == pytest.approx(0.0, abs=1e-12)


def test_covariance_is_that_of_many_measurements():
    rng, sigma = np.random.default_rng(0), 0.004
    found = from_four(*readings(0.1, 0.02, 0.4, sigma, 20000, rng), sigma)
    sampled = np.cov(np.stack([found.k1, found.k2, found.theta]))
    assert np.allclose(np.sqrt(np.diag(sampled)), np.sqrt(np.diag(found.covariance.mean(axis=0))), rtol=0.03)
    assert np.sqrt(found.covariance[0, 0, 0]) == pytest.approx(np.sqrt(0.75) * sigma)


def test_redundancy_is_a_calibrated_test():
    rng, sigma = np.random.default_rng(1), 0.004
    found = from_four(*readings(0.1, 0.02, 0.4, sigma, 20000, rng), sigma)
    assert found.z.std() == pytest.approx(1.0, abs=0.02)
    assert (found.consistency < 0.05).mean() == pytest.approx(0.05, abs=0.006)
    broken = from_four(0.1 + 0.05, 0.1, 0.1, 0.1, sigma)
    assert broken.consistency[0] < 1e-6


def test_unequal_sigmas_are_propagated():
    sigmas = np.array([[0.001, 0.002, 0.003, 0.004]])
    found = from_four(0.1, 0.05, 0.0, 0.05, sigmas)
    assert np.sqrt(found.components_covariance[0, 0, 0]) == pytest.approx(np.sqrt((sigmas**2).sum()) / 4)


@pytest.mark.parametrize(
    ("k1", "k2", "order"),
    [
        (0, 0, 0),
        (0.07, 0, 1),
        (0, -0.07, 1),
        (0.07, 0.07, 2),
        (-0.07, -0.07, 2),
        (0.1, 0.03, 3),
        (0.05, -0.05, 3),
    ],
)
def test_orders_are_named_at_the_published_rate_or_better(k1, k2, order):
    rng, sigma = np.random.default_rng(2), 0.004
    chances = name_order(from_four(*readings(k1, k2, 0.3, sigma, 400, rng), sigma))
    assert chances.shape == (400, len(ORDERS))
    assert np.allclose(chances.sum(axis=1), 1.0)
    assert (chances.argmax(axis=1) == order).mean() >= 0.97


def test_order_does_not_depend_on_the_direction_of_the_first_stroke():
    turned = [name_order(from_four(*readings(0.05, 0.0, theta), 0.005))[0] for theta in np.linspace(0, 3, 7)]
    assert np.allclose(turned, turned[0], atol=1e-3)


def test_oblique_sections_obey_meusnier():
    # the section of a cylinder by a plane tilted about the tangent is an ellipse of curvature kappa / cos(tilt)
    tilt, radius = 0.5, 12.0
    ellipse = (radius / np.cos(tilt)) / radius**2
    assert Cylinder([0, 0, 0], [0, 0, 1], radius).principal_curvatures(np.array([[radius, 0, 0]]))[0, 0] == (
        pytest.approx(float(normal_curvature(1.0 / radius / np.cos(tilt), tilt)))
    )
    assert ellipse > 1 / radius
