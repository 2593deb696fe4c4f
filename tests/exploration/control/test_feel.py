"""What the servo reads off one frame, against the sums of numpy and scipy."""

import numpy as np
import pytest
from scipy.ndimage import binary_erosion, uniform_filter

from exploration.control.feel import FeelConfig, NotTouching, feel
from exploration.sensing.frame import TactileImage, TaxelArray

PAD = TaxelArray("pad", 10, 16, (1.8, 1.8))


def image(depth: np.ndarray, sigma: np.ndarray) -> TactileImage:
    return TactileImage(PAD, depth, sigma, 1.8, 0.1, 0.0)


def test_a_frame_is_felt_as_its_least_squares_paraboloid():
    config, rng = FeelConfig(), np.random.default_rng(0)
    gx, gy = np.meshgrid(PAD.x, PAD.y)
    for _ in range(10):
        center, slope = rng.uniform(-3, 3, 2), rng.uniform(-0.02, 0.02, 2)
        depth = 0.5 + slope[0] * gx + slope[1] * gy - 0.01 * ((gx - center[0]) ** 2 + (gy - center[1]) ** 2)
        depth = np.maximum(depth, 0.0) + 0.01 * rng.standard_normal(PAD.shape)
        sigma = np.where(rng.random(PAD.shape) < 0.05, np.inf, 0.01)
        felt = feel(image(depth, sigma), config)
        smooth = uniform_filter(np.where(np.isfinite(sigma), depth, 0.0), 3, mode="nearest")
        mask = np.isfinite(sigma) & (smooth > config.share * smooth.max())
        inner = binary_erosion(mask, iterations=2, border_value=1)
        assert (felt.mask == mask).all()
        assert (felt.inner == inner).all()
        use = inner if inner.sum() >= config.enough else mask
        u, v = gx[use] - felt.centroid[0], gy[use] - felt.centroid[1]
        rows = np.stack([np.ones(len(u)), u, v, -(u**2) / 2, -u * v, -(v**2) / 2], axis=1) / 0.01
        hold = np.array([0.0, 1.0, 1.0, *[config.prior_sigma**-2.0] * 3])
        right = rows.T @ (depth[use] / 0.01) + hold * config.prior_curvature * [0, 0, 0, 1, 0, 1]
        c = np.linalg.solve(rows.T @ rows + np.diag(hold), right)
        assert felt.hessian == pytest.approx(np.array([[c[3], c[4]], [c[4], c[5]]]))
        assert felt.slope == pytest.approx(c[1:3] + felt.hessian @ felt.centroid)
        assert felt.depth == pytest.approx(c[0] + 0.5 * 1.8**2 * max(c[3] + c[5], 0.0))


def test_nothing_and_dead_taxels_are_told_apart():
    none = np.zeros(PAD.shape)
    assert feel(image(none, none + 0.01)) == NotTouching()
    assert feel(image(none + 0.5, none + np.inf)).reason == "every taxel is dead"


@pytest.mark.parametrize("radius", [22.0, np.inf])
def test_between_two_lands_it_is_felt_how_deep_the_pad_lies_on_them_whatever_the_noise(radius):
    (gx, gy), rng = np.meshgrid(PAD.x, PAD.y), np.random.default_rng(0)
    along = np.maximum(0.5 - gx**2 / (2 * radius), 0.0)
    lands = along * np.clip((np.abs(gy) - 4.0) / 3.0, 0.0, 1.0)  # their inner sides are blurred
    for _ in range(50):
        felt = feel(image(lands + 0.01 * rng.standard_normal(PAD.shape), np.full(PAD.shape, 0.01)))
        assert felt.depth == pytest.approx(lands[felt.mask].mean(), abs=0.01)
        assert felt.depth > 0.2


def test_a_dead_taxel_in_the_middle_is_no_groove():
    depth, sigma = np.full(PAD.shape, 0.5), np.full(PAD.shape, 0.01)
    sigma[4:6, 7:9] = np.inf
    gx, gy = np.meshgrid(PAD.x, PAD.y)
    dome = depth - (gx**2 + gy**2) / 300.0
    assert feel(image(dome, sigma)).depth == pytest.approx(
        feel(image(dome, np.full(PAD.shape, 0.01))).depth, abs=0.02
    )
