"""A smooth surface through contacts."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from primitives.errors import PalpateError
from primitives.implicit_surface import _covariance, implicit_surface
from primitives.pose import rotation_exp

MIDDLE = np.array([5.0, -3.0, 2.0])


def ball(count=250, radius=30.0, seed=0):
    ways = np.random.default_rng(seed).normal(size=(count, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    return MIDDLE + radius * ways, ways


def through(points, normals, *more):
    return implicit_surface(points, normals, np.full(len(points), 0.01), np.full(len(points), 0.01), *more)


def test_a_ball_is_found_between_its_contacts():
    surface = through(*ball())
    points, ways = ball(400, seed=1)
    assert np.abs(surface.values(points)).max() < 0.2
    for off in (-2.0, 2.0):
        assert np.abs(surface.values(points + off * ways) - off).max() < 0.3


@settings(max_examples=10, deadline=None)
@given(st.lists(st.floats(-2.0, 2.0), min_size=6, max_size=6))
def test_it_moves_with_its_contacts(motion):
    turn, shift = rotation_exp(motion[:3]), 50.0 * np.array(motion[3:])
    points, normals = ball(60)
    places = ball(40, 26.0, seed=2)[0]
    moved = through(points @ turn.T + shift, normals @ turn.T)
    assert np.allclose(
        moved.values(places @ turn.T + shift), through(points, normals).values(places), atol=1e-6
    )


def test_the_covariance_of_slopes_is_the_derivative_of_that_of_values():
    rng = np.random.default_rng(3)
    valued, sloped, longest, step = rng.normal(size=(4, 3)), rng.normal(size=(3, 3)), 12.0, 1e-4

    def of_values(a, b):
        return _covariance(np.array([a, b]), np.empty((0, 3)), longest)[0, 1]

    out = _covariance(valued, sloped, longest)
    for i, axis in np.ndindex(3, 3):
        aside = step * np.eye(3)[axis]
        for j in range(4):
            slope = (of_values(sloped[i] + aside, valued[j]) - of_values(sloped[i] - aside, valued[j])) / (
                2 * step
            )
            assert out[4 + 3 * axis + i, j] == pytest.approx(slope, abs=1e-6)
        for j, other in np.ndindex(3, 3):
            if i == j:
                continue
            beside = step * np.eye(3)[other]
            corners = [
                a * b * of_values(sloped[i] + a * aside, sloped[j] + b * beside)
                for a in (1, -1)
                for b in (1, -1)
            ]
            bent = sum(corners) / (4 * step**2)
            assert out[4 + 3 * axis + i, 4 + 3 * other + j] == pytest.approx(bent, abs=1e-5)
    assert np.linalg.eigvalsh(out).min() > 0.0
    assert np.allclose(out, out.T)


def test_places_elsewhere_keep_it_away():
    points, normals = ball()
    cap = normals[:, 2] > 0.7  # never felt
    top = MIDDLE + np.array([[0.0, 0.0, 25.0], [4.0, 0.0, 25.0], [-4.0, 0.0, 25.0]])
    before = through(points[~cap], normals[~cap]).values(top)
    after = through(points[~cap], normals[~cap], top, np.full(3, 1.0)).values(top)
    assert (before < -2.0).all()
    assert (after > 0.0).all()


def test_contacts_at_one_place_are_refused():
    with pytest.raises(PalpateError, match="more than one place"):
        through(np.zeros((4, 3)), np.tile([0.0, 0.0, 1.0], (4, 1)))
