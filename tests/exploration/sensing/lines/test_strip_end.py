"""Where the strip of contact on a cylinder ends."""

import numpy as np
import pytest

from exploration.sensing.frame import TactileImage, TaxelArray
from exploration.sensing.lines.strip_end import fit_strip_end
from exploration.sensing.response import rubber

PAD = TaxelArray("pad", 10, 16, (1.8, 1.8))
SPREAD, NOISE = 1.2, 0.02


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
