"""Where the strip of contact on a cylinder ends."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from exploration.sensing.frame import TactileImage, TaxelArray
from exploration.sensing.lines.strip_end import fit_strip_end
from exploration.sensing.response import rubber

PAD = TaxelArray("pad", 10, 16, (1.8, 1.8))
SPREAD, NOISE = 1.2, 0.02
WIDE = TaxelArray("wide", 14, 6, (3.4, 3.4))


def strip(end, heading, rng, rise=0.0, radius=20.0):
    """A frame of a cylinder along a way, pressed 0.5 mm deep, that ends `end` mm from the pad's middle."""
    heading = np.asarray(heading, dtype=float) / np.linalg.norm(heading)
    x, y = np.meshgrid(PAD.x, PAD.y)
    before, aside = end - (x * heading[0] + y * heading[1]), y * heading[0] - x * heading[1]
    blur = rubber(SPREAD, PAD.pitch)
    profile = 0.5 * np.exp(-0.5 * aside**2 / (0.15 * radius))
    depth = profile * (1.0 + rise * before) * blur.edge(before, blur.width(heading))
    noisy = depth + NOISE * rng.standard_normal(depth.shape)
    return TactileImage(PAD, noisy, np.full(depth.shape, NOISE), SPREAD, 0.1, 0.0), heading


def pressed(array, spread, noise, end, way, radius, rng):
    """A frame of a cylinder along a way [rad], pressed 0.5 mm deep, cut straight, blurred and binned finely."""
    fine, rim = 6, 3
    nx, ny = ((n + 2 * rim) * fine for n in (array.columns, array.rows))
    dx, dy = array.pitch[0] / fine, array.pitch[1] / fine
    x, y = np.meshgrid((np.arange(nx) - (nx - 1) / 2) * dx, (np.arange(ny) - (ny - 1) / 2) * dy)
    before = end - x * np.cos(way) - y * np.sin(way)
    aside = y * np.cos(way) - x * np.sin(way) - rng.uniform(-1.0, 1.0)
    depth = np.maximum(0.5 - aside**2 / (2.0 * radius), 0.0) * np.clip(before / dx + 0.5, 0.0, 1.0)
    depth = gaussian_filter(depth, (spread / dy, spread / dx))
    depth = depth.reshape(ny // fine, fine, nx // fine, fine).mean(axis=(1, 3))[rim:-rim, rim:-rim]
    sigma = noise * depth.max()
    noisy = depth + sigma * rng.standard_normal(depth.shape)
    return TactileImage(array, noisy, np.full(depth.shape, sigma), spread, 0.1, 0.0)


@pytest.mark.parametrize("radius", [5.0, 20.0])
@pytest.mark.parametrize("degrees", [0, 6, 10, 15, 20, 45, 90])
@pytest.mark.parametrize(("array", "spread", "noise"), [(PAD, SPREAD, 0.05), (WIDE, 1.7, 0.02)])
def test_an_end_across_the_taxels_is_as_sure_as_is_stated(array, spread, noise, degrees, radius):
    rng, way, count = np.random.default_rng(4), np.radians(degrees), 10
    off, sigma = [], []
    for end in rng.uniform(-1.0, 3.0, count):
        image = pressed(array, spread, noise, end, way, radius, rng)
        if found := fit_strip_end(image, np.array([np.cos(way), np.sin(way)])):
            off.append(found.offset - end)
            sigma.append(found.sigma)
    assert len(off) == count or array is WIDE
    if len(off) > 3:
        assert abs(np.mean(off)) < 0.8 * np.mean(sigma)
        assert np.sqrt(np.mean(np.square(np.divide(off, sigma)))) < 1.3


@pytest.mark.parametrize("askew", [-10, 5])
@pytest.mark.parametrize("degrees", [0, 30])
def test_a_way_that_is_some_degrees_off_the_strip_meets_its_end(degrees, askew):
    rng, axis, way = np.random.default_rng(5), np.radians(degrees), np.radians(degrees + askew)
    heading, left = np.array([np.cos(way), np.sin(way)]), np.array([-np.sin(way), np.cos(way)])
    x, y = np.meshgrid(PAD.x, PAD.y)
    off = []
    for end in rng.uniform(-1.0, 3.0, 12):
        image = pressed(PAD, SPREAD, 0.05, end, axis, 10.0, rng)
        found = fit_strip_end(image, heading)
        weight = np.where(image.depth > 0.15 * image.depth.max(), image.depth, 0.0)
        level = np.average(x * left[0] + y * left[1], weights=weight)
        met = found.offset * heading + level * left
        off.append((met @ [np.cos(axis), np.sin(axis)] - end) / found.sigma)
    assert np.sqrt(np.mean(np.square(off))) < 1.3


@pytest.mark.parametrize("degrees", [0, 8, 45, 90])
@pytest.mark.parametrize("askew", [0, 45, 90])
def test_a_strip_that_goes_on_or_another_way_has_no_end(degrees, askew):
    rng, axis, way = np.random.default_rng(6), np.radians(degrees), np.radians(degrees + askew)
    heading = np.array([np.cos(way), np.sin(way)])
    for end in (3.0, 60.0)[askew == 0 :]:
        for _ in range(5):
            assert fit_strip_end(pressed(PAD, SPREAD, 0.03, end, axis, 6.0, rng), heading) is None


@pytest.mark.parametrize("heading", [(1.0, 0.0), (0.0, -1.0), (0.1, 1.0), (-1.0, 0.1)])
@pytest.mark.parametrize("rise", [0.0, 0.02])
def test_the_end_is_where_it_is_and_as_sure_as_is_stated(heading, rise):
    rng = np.random.default_rng(0)
    off = []
    for end in rng.uniform(-2.0, 4.0, 40):
        found = fit_strip_end(*strip(end, heading, rng, rise))
        off.append((found.offset - end) / found.sigma)
    assert 0.5 < np.sqrt(np.mean(np.square(off))) < 1.5


def test_a_strip_that_goes_on_has_no_end():
    rng = np.random.default_rng(1)
    assert all(fit_strip_end(*strip(40.0, (1.0, 0.0), rng)) is None for _ in range(20))


def test_a_ball_has_no_end():
    rng = np.random.default_rng(2)
    x, y = np.meshgrid(PAD.x, PAD.y)
    for _ in range(20):
        depth = 0.6 * np.exp(-(x**2 + y**2) / 18.0) + NOISE * rng.standard_normal(x.shape)
        image = TactileImage(PAD, depth, np.full(depth.shape, NOISE), SPREAD, 0.1, 0.0)
        assert fit_strip_end(image, np.array([1.0, 0.0])) is None


def test_taxels_that_are_dead_tell_nothing():
    image, heading = strip(2.0, (1.0, 0.0), np.random.default_rng(3))
    depth, sigma = image.depth.copy(), np.full(image.depth.shape, NOISE)
    depth[4, :] = np.nan
    sigma[4, :] = np.inf
    dead = TactileImage(PAD, depth, sigma, SPREAD, 0.1, 0.0)
    assert fit_strip_end(dead, heading).offset == pytest.approx(2.0, abs=0.3)
