"""The load of a frame against plain sums, and contact told from noise."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.sensing.frame import TactileImage, TaxelArray
from exploration.sensing.load import load_of, stands_out

ARRAY = TaxelArray("pad", 10, 16, (1.8, 1.5))


@pytest.fixture
def image():
    rng = np.random.default_rng(5)
    sigma = rng.uniform(0.01, 0.03, ARRAY.shape)
    sigma[3, 4] = sigma[0, 0] = np.inf
    return TactileImage(ARRAY, rng.uniform(0.0, 0.6, ARRAY.shape), sigma, 1.2, 0.1, 0.0)


def test_a_load_is_the_sum_over_living_taxels(image):
    live = np.isfinite(image.sigma)
    pressed = np.where(live, image.depth, 0.0) * image.stiffness * 1.8 * 1.5
    load = load_of(image)
    assert load.force == pytest.approx(pressed.sum())
    assert load.about_x == pytest.approx(-(ARRAY.y @ pressed).sum())
    assert load.about_y == pytest.approx((pressed @ ARRAY.x).sum())
    assert load.sigma == pytest.approx(0.1 * 1.8 * 1.5 * np.sqrt((image.sigma[live] ** 2).sum()))


def test_the_peak_is_the_deepest_mean_of_two_by_two(image):
    depth = np.where(np.isfinite(image.sigma), image.depth, 0.0)
    mean = np.lib.stride_tricks.sliding_window_view(depth, (2, 2)).mean(axis=(2, 3))
    assert load_of(image).peak == pytest.approx(mean.max())


def test_a_lone_taxel_has_its_own_depth_as_peak():
    lone = TaxelArray("probe", 1, 1, (3.0, 3.0))
    probe = TactileImage(lone, np.array([[0.4]]), np.array([[0.01]]), 1.0, 0.1, 0.0)
    assert load_of(probe).peak == pytest.approx(0.4)


def test_contact_stands_out_where_neighbors_do_together(image):
    rng = np.random.default_rng(6)
    noise = replace(image, depth=0.02 * rng.standard_normal(ARRAY.shape), sigma=np.full(ARRAY.shape, 0.02))
    assert not stands_out(noise, 6.0)
    depth = noise.depth.copy()
    depth[4:7, 5:8] += 0.06
    assert stands_out(replace(noise, depth=depth), 6.0)


def test_dead_taxels_neither_start_nor_hide_a_contact(image):
    depth = np.zeros(ARRAY.shape)
    depth[:, 8:] = 5.0
    sigma = np.full(ARRAY.shape, 0.02)
    sigma[:, 8:] = np.inf
    assert not stands_out(replace(image, depth=depth, sigma=sigma), 6.0)
    assert not stands_out(replace(image, depth=depth, sigma=np.full(ARRAY.shape, np.inf)), 6.0)
