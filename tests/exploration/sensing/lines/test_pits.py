"""Narrow holes in a flat contact, from one frame."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter

from exploration.sensing.frame import TactileImage, TaxelArray
from exploration.sensing.lines.pits import pits

ARRAY, FINE = TaxelArray("lts210", 10, 16, (1.8, 1.8)), 12
SPREAD, PRESS = 0.9, 0.6


def image(holes, on=lambda x, y: np.ones_like(x, bool), noise=0.0, slope=0.0, seed=0):
    """A face at `PRESS` mm with round holes (x, y, radius), blurred finely and averaged over the taxels."""
    cell = ARRAY.pitch[0] / FINE
    x, y = ((np.arange(n * FINE) + 0.5) * cell - 0.5 * n * ARRAY.pitch[0] for n in (16, 10))
    x, y = np.meshgrid(x, y)
    there = on(x, y) & np.all([np.hypot(x - a, y - b) > r for a, b, r in holes] + [x < np.inf], axis=0)
    depth = gaussian_filter((PRESS + slope * x) * there, SPREAD / cell, mode="nearest")
    depth = depth.reshape(10, FINE, 16, FINE).mean(axis=(1, 3))
    depth = depth + noise * np.random.default_rng(seed).standard_normal(depth.shape)
    return TactileImage(ARRAY, depth, np.full(depth.shape, max(noise, 1e-3)), SPREAD, 0.05, 0.0)


@given(st.floats(-6.0, 6.0), st.floats(-2.5, 2.5), st.floats(2.0, 3.5), st.floats(-0.008, 0.008))
def test_a_hole_is_where_it_is_and_as_wide_as_what_is_missing(x, y, radius, slope):
    (pit,) = pits(image([(x, y, radius)], slope=slope))
    assert pit.center == pytest.approx([x, y], abs=0.15)
    assert pit.radius == pytest.approx(radius, abs=0.25)
    assert pit.depth == pytest.approx(PRESS + slope * x, abs=0.03)


def test_two_holes_are_two_and_a_hole_in_a_narrow_ring_is_one():
    found = pits(image([(-7.0, 1.0, 2.5), (6.0, -1.0, 2.0)]))
    assert sorted(round(float(pit.center[0])) for pit in found) == [-7, 6]
    (pit,) = pits(image([(0.0, 0.0, 2.5)], on=lambda x, y: np.hypot(x, y) < 8.0))
    assert np.linalg.norm(pit.center) < 0.2


@pytest.mark.parametrize(
    "on",
    [
        lambda x, y: np.ones_like(x, bool),
        lambda x, y: x < 4.0,
        lambda x, y: np.abs(x) > 2.5,  # a slot from side to side
        lambda x, y: (x < -3.0) | (y < -2.0),  # an inside corner
    ],
)
@pytest.mark.parametrize("seed", range(5))
def test_a_face_a_rim_a_slot_and_noise_show_none(on, seed):
    assert pits(image([], on=on, noise=0.05, seed=seed)) == []


def test_a_hole_is_told_from_noise_and_a_dead_taxel_is_none():
    (pit,) = pits(image([(3.0, 1.0, 2.5)], noise=0.03))
    assert pit.center == pytest.approx([3.0, 1.0], abs=0.4)
    whole = image([])
    sigma, depth = whole.sigma.copy(), whole.depth.copy()
    depth[4, 7], sigma[4, 7] = 0.0, np.inf
    assert pits(replace(whole, depth=depth, sigma=sigma)) == []
    assert pits(replace(whole, depth=0.0 * depth)) == []


@pytest.mark.parametrize("long", [10.0, 14.0, 20.0])
def test_a_slots_mouth_is_none(long):
    assert pits(image([], on=lambda x, y: (np.abs(x) > 0.5 * long) | (np.abs(y) > 1.8))) == []
