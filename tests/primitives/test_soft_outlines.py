"""Polygons from pictures as soft as a pad's images, against the regions that were drawn."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter, zoom

from primitives.arcs import arcs
from primitives.outlines import depth_inside, signed_area, simplified, traced
from primitives.soft_outlines import sharpened
from primitives.soft_pictures import drawn

STEP, SHAPE = 0.5, (120, 140)
MIDDLE = 0.5 * STEP * np.array(SHAPE)


def ring(radius, corners=256, turn=0.0):
    t = turn + 2.0 * np.pi * np.arange(corners) / corners
    return MIDDLE + radius * np.column_stack([np.cos(t), np.sin(t)])


def teeth(count, inner, outer):
    t = np.linspace(0.0, 2.0 * np.pi, 4 * count, endpoint=False)
    radius = np.tile([inner, outer, outer, inner], count)
    return MIDDLE + radius[:, None] * np.column_stack([np.cos(t), np.sin(t)])


BLOCK = MIDDLE + np.array(
    [[-20.0, -14.0], [18.0, -14.0], [18.0, 3.0], [6.0, 3.0], [6.0, 14.0], [-20.0, 14.0]]
)


def seen(rims, soft, noise=0.02, seed=0):
    """A picture of rims, with errors as smooth as those of images that are joined."""
    off = gaussian_filter(np.random.default_rng(seed).standard_normal(SHAPE), 0.8 / STEP)
    sharp = np.clip(drawn(rims, SHAPE, STEP, 8), 0.0, 1.0)
    return gaussian_filter(sharp, soft / STEP) + noise * off / off.std()


def half(share):
    """Rims where a picture comes to one half."""
    fine = zoom(share, 2, order=1, grid_mode=True, mode="nearest")
    return [simplified(((loop - 1.0) / 2.0)[:, ::-1] * STEP, 0.4)[:-1] for loop in traced(fine > 0.5)]


def wrong(rims, truth):
    """Share of the true region that is there and should not be, or is not."""
    true = drawn(truth, SHAPE, STEP, 8)
    return float(np.abs(drawn(rims, SHAPE, STEP, 8) - true).sum() / true.sum())


WHOLE = np.ones(SHAPE, dtype=bool)


def test_a_polygon_covers_of_each_cell_what_it_covers():
    inside = drawn([BLOCK], SHAPE, STEP)
    assert inside.sum() * STEP**2 == pytest.approx(abs(signed_area(BLOCK)), rel=1e-6)
    i, j = np.meshgrid(np.arange(SHAPE[0]), np.arange(SHAPE[1]), indexing="ij")
    depth = depth_inside([BLOCK], STEP * np.column_stack([i.ravel(), j.ravel()])).reshape(SHAPE)
    assert (inside[depth > STEP] == 1.0).all()
    assert (inside[depth < -STEP] == 0.0).all()
    hole = ring(4.0)[::-1]
    assert drawn([ring(10.0), hole], SHAPE, STEP).sum() * STEP**2 == pytest.approx(84.0 * np.pi, rel=1e-2)


@pytest.mark.parametrize("soft", [0.8, 1.3, 1.6])
@pytest.mark.parametrize("truth", [[BLOCK], [teeth(12, 20.0, 26.0), ring(6.0)[::-1]]], ids=["block", "gear"])
def test_corners_that_softness_cut_off_come_back(truth, soft):
    share = seen(truth, soft)
    before = half(share)
    after = sharpened(share, WHOLE, before, STEP)
    assert wrong(after, truth) < max(0.7 * wrong(before, truth), 0.004)
    assert wrong(after, truth) < 0.04
    assert max(map(len, after)) <= max(6, 1.6 * max(map(len, truth)))


def test_a_block_has_as_many_corners_as_it_has():
    (made,) = sharpened(share := seen([BLOCK], 1.4), WHOLE, half(share), STEP)
    assert len(made) == len(BLOCK)
    assert max(np.linalg.norm(made - corner, axis=1).min() for corner in BLOCK) < 0.4


@pytest.mark.parametrize("radius", [4.0, 6.0, 12.0, 24.0])
def test_a_hole_is_as_wide_as_it_is_and_round(radius):
    share = 1.0 - seen([ring(radius)], 1.5, seed=int(radius))
    known = np.hypot(*(np.indices(SHAPE) * STEP - MIDDLE[:, None, None])) < radius + 6.0
    share = np.where(known, share, 0.0)
    made = sharpened(share, known, half(share), STEP)
    (arc,) = [arc for rim in made for arc in arcs(rim) if abs(arc.radius - radius) < 2.0]
    assert arc.radius == pytest.approx(radius, abs=0.03)
    assert np.linalg.norm(arc.center - MIDDLE) < 0.06


def test_where_nothing_was_seen_nothing_is_told():
    known = np.indices(SHAPE)[1] * STEP < MIDDLE[1]
    share = np.where(known, seen([BLOCK], 1.4), 0.0)
    made = sharpened(share, known, half(share), STEP)
    assert wrong(made, half(share)) < 0.1


def test_a_spike_between_two_like_corners_goes_and_leaves_numbers():
    spike = np.array([[10.0, 10], [40, 10], [40, 25], [45, 25], [40, 25], [40, 40], [10, 40]])
    square = spike[[0, 1, 5, 6]]
    (made,) = sharpened(seen([square], 1.3), WHOLE, [spike], STEP)
    assert np.isfinite(made).all()
    assert wrong([made], [square]) < 0.01


def test_small_rims_stay_as_they_are():
    speck = MIDDLE + np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    share = seen([speck], 0.3, noise=0.0)
    assert sharpened(share, WHOLE, [speck], STEP)[0] is speck
    assert sharpened(share, WHOLE, [], STEP) == ()
