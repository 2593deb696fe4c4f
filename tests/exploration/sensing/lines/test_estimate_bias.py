from dataclasses import replace

import numpy as np

from exploration.sensing.lines.estimate_bias import bias_of
from exploration.sensing.lines.region import NO_TERMS, Region
from exploration.sensing.lines.region_fit import LEVEL, fit_region
from exploration.sensing.response import response_of


def test_small_discs_are_off_by_their_second_order_bias_on_average(frames):
    """Which is a sixth of a deviation, so that many fits show it."""
    rng = np.random.default_rng(0)
    radius, boss = 3.0, Region((), NO_TERMS, (1.0,))
    clean = frames(lambda x, y: 0.5 * np.clip((radius - np.hypot(x, y)) / 0.225 + 0.5, 0.0, 1.0))
    off, expected = [], []
    for _ in range(600):
        image = replace(clean, depth=clean.depth + frames.noise * rng.standard_normal(clean.depth.shape))
        response = response_of(image)
        fit = fit_region(image, response, boss, (0.0, 0.0, radius), slope=LEVEL)
        off.append(fit.parameters[5] - radius)
        expected.append(bias_of(image, response, fit)[5])
    sigma = np.std(off) / np.sqrt(len(off))
    assert np.mean(off) > 2 * sigma
    assert abs(np.mean(off) - np.mean(expected)) < 2.5 * sigma
    assert np.std(np.subtract(off, expected)) < np.std(off)
