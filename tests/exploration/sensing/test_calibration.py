"""Censored readings: what saturates, and what a controller holds at zero."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.sensing.calibration import Calibration, correct
from exploration.sensing.frame import TaxelFrame
from exploration.sensing.touch import perceive
from primitives.arrays import frozen

COUNTS = 4000.0  # per mm
NOISE, THRESHOLD, CEILING = 6.0, 60.0, 1300.0


def calibration_of(array, spread):
    shape = array.shape
    return Calibration(
        frozen(np.zeros(shape)), frozen(np.full(shape, COUNTS)), frozen(np.zeros(shape), np.bool_),
        spread, 1.0, NOISE,
    )  # fmt: skip


def delivered(image, rng):
    counts = np.round(COUNTS * image.depth + NOISE * rng.standard_normal(image.depth.shape))
    return TaxelFrame(frozen(np.where(counts < THRESHOLD, 0.0, np.minimum(counts, CEILING))), 0.0, 0)


@pytest.fixture
def coarse(frames):
    return type(frames)(rows=14, columns=6, pitch=3.4, spread=1.7)


def test_a_ball_keeps_its_radius_where_taxels_saturate_and_a_threshold_cuts(coarse):
    rng = np.random.default_rng(1)
    blind = calibration_of(coarse.array, coarse.spread)
    told = replace(blind, full_scale=CEILING, threshold=THRESHOLD)
    away = {"blind": [], "told": []}
    for _ in range(12):
        frame = delivered(coarse(coarse.sphere(21.0, *rng.uniform(-2, 2, 2))), rng)
        for name, calibration in (("blind", blind), ("told", told)):
            touch = perceive(correct(frame, calibration, coarse.array))
            away[name].append(np.log(touch.surface.radius[0] / 21.0) if touch.surface.curved else np.nan)
    assert np.abs(np.nanmedian(away["told"])) < 0.25
    assert np.abs(np.nanmedian(away["told"])) < 0.7 * np.abs(np.nanmedian(away["blind"]))


def test_only_zeros_beside_a_touched_taxel_are_doubted(coarse):
    told = replace(calibration_of(coarse.array, coarse.spread), threshold=THRESHOLD)
    counts = np.zeros(coarse.array.shape)
    counts[5, 3] = 800.0
    sigma = correct(TaxelFrame(frozen(counts), 0.0, 0), told, coarse.array).sigma * COUNTS
    assert sigma[5, 2] == pytest.approx(np.hypot(NOISE, THRESHOLD))
    assert sigma[5, 1] == pytest.approx(NOISE)
    assert sigma[5, 3] == pytest.approx(NOISE)


def test_a_saturated_taxel_is_sure_of_no_more_than_its_depth_or_so(coarse):
    told = replace(calibration_of(coarse.array, coarse.spread), full_scale=CEILING)
    counts = np.full(coarse.array.shape, 100.0)
    counts[5, 3] = CEILING
    image = correct(TaxelFrame(frozen(counts), 0.0, 0), told, coarse.array)
    assert image.sigma[5, 3] > 0.2 * image.depth[5, 3]
    assert image.sigma[0, 0] < 0.1 * image.depth[0, 0]
    assert np.argwhere(image.saturated).tolist() == [[5, 3]]
    assert not image.saturated.flags.writeable
    stuck = replace(told, dead=frozen(counts >= CEILING, bool))
    assert not correct(TaxelFrame(frozen(counts), 0.0, 0), stuck, coarse.array).saturated.any()
    assert (
        correct(TaxelFrame(frozen(np.full_like(counts, 100.0)), 0.0, 0), told, coarse.array).saturated is None
    )
