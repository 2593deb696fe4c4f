"""Intervals of what trials told: of a share (Wilson 1927), of a median (percentile bootstrap, Efron 1979).

With k of n and z the normal quantile, the share's interval is
(k + z^2/2 +- z sqrt(k (n - k)/n + z^2/4)) / (n + z^2).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import norm

LEVEL = 0.95
DRAWS = 2000


@dataclass(frozen=True)
class Estimate:
    """A number and its interval."""

    value: float
    low: float
    high: float
    count: int


def wilson(right: int, count: int, level: float = LEVEL) -> Estimate | None:
    """Of a share."""
    if not count:
        return None
    z = float(norm.ppf(0.5 + level / 2.0))
    middle = (right + z * z / 2.0) / (count + z * z)
    half = z * np.sqrt(right * (count - right) / count + z * z / 4.0) / (count + z * z)
    return Estimate(right / count, max(0.0, float(middle - half)), min(1.0, float(middle + half)), count)


def median(values: Sequence[float], level: float = LEVEL, seed: int = 0) -> Estimate | None:
    """Of a median; the same draws for the same seed."""
    told = np.sort(np.asarray(values, dtype=float))
    if not len(told):
        return None
    drawn = np.random.default_rng(seed).integers(0, len(told), (DRAWS, len(told)))
    low, high = np.quantile(np.median(told[drawn], axis=1), [0.5 - level / 2.0, 0.5 + level / 2.0])
    return Estimate(float(np.median(told)), float(low), float(high), len(told))
