"""Intervals of what trials told, where trials come in units (parts) whose trials resemble each other.

A share's interval is Wilson's (1927) with n trials in m units counted as n / D of them, D being the design effect:
the ratio estimator's variance between units over the binomial one (Kish 1965), at least 1; where all trials agree
nothing is known of D, and the units are counted.  With k = p n and z the normal quantile::

    (k + z^2/2 +- z sqrt(k (n - k)/n + z^2/4)) / (n + z^2)

A median's and a mean's are percentile bootstraps over whole units (Efron 1979; Field and Welsh 2007); the mean of
paired differences has Student's interval (1908).
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import norm, t

from primitives.arrays import Floats

LEVEL = 0.95
DRAWS = 2000
Unit = Hashable


@dataclass(frozen=True)
class Estimate:
    """A number and its interval; the interval is None where there is too little to tell."""

    value: float
    low: float | None
    high: float | None
    count: int  # trials
    units: int  # among which they are


def wilson(right: float, count: float, level: float = LEVEL) -> tuple[float, float]:
    """The interval of a share; counts need not be whole."""
    z = float(norm.ppf(0.5 + level / 2.0))
    middle = (right + z * z / 2.0) / (count + z * z)
    half = z * np.sqrt(right * (count - right) / count + z * z / 4.0) / (count + z * z)
    return max(0.0, float(middle - half)), min(1.0, float(middle + half))


def share(
    right: Sequence[bool], units: Sequence[Unit] | None = None, level: float = LEVEL
) -> Estimate | None:
    """How many were right; None of nothing."""
    told = np.asarray(right, dtype=float)
    if not len(told):
        return None
    members = _members(len(told), units)
    n, p = len(told), float(told.mean())
    low, high = wilson(p * n / _design(told, members), n / _design(told, members), level)
    return Estimate(p, low, high, n, len(members))


def median(
    values: Sequence[float], units: Sequence[Unit] | None = None, level: float = LEVEL
) -> Estimate | None:
    """The middle of the values; None of nothing."""
    told = np.asarray(values, dtype=float)
    if not len(told):
        return None
    members = _members(len(told), units)
    if len(members) == 1:
        return Estimate(float(np.median(told)), None, None, len(told), 1)
    drawn = np.random.default_rng(0).integers(0, len(members), (DRAWS, len(members)))
    if all(len(rows) == 1 for rows in members):
        medians = np.median(told[drawn], axis=1)
    else:
        medians = np.array([np.median(told[np.concatenate([members[k] for k in draw])]) for draw in drawn])
    low, high = np.quantile(medians, [0.5 - level / 2.0, 0.5 + level / 2.0])
    return Estimate(float(np.median(told)), float(low), float(high), len(told), len(members))


def mean_of_units(
    values: Sequence[float], units: Sequence[Unit] | None = None, level: float = LEVEL
) -> Estimate | None:
    """The mean over units of their means, with Student's interval; None of nothing."""
    told = np.asarray(values, dtype=float)
    if not len(told):
        return None
    members = _members(len(told), units)
    means = np.array([told[rows].mean() for rows in members])
    middle = float(means.mean())
    if len(means) < 2:
        return Estimate(middle, None, None, len(told), len(means))
    half = float(t.ppf(0.5 + level / 2.0, len(means) - 1) * means.std(ddof=1) / np.sqrt(len(means)))
    return Estimate(middle, middle - half, middle + half, len(told), len(means))


def _members(count: int, units: Sequence[Unit] | None) -> list[np.ndarray]:
    """Rows of each unit; each row is its own where units are not told."""
    if units is None:
        return [np.array([row]) for row in range(count)]
    rows: dict[Unit, list[int]] = {}
    for row, unit in enumerate(units):
        rows.setdefault(unit, []).append(row)
    return [np.array(mine) for mine in rows.values()]


def _design(told: Floats, members: list[np.ndarray]) -> float:
    """By how much trials of one unit count less than trials of different ones."""
    n, m, p = len(told), len(members), float(told.mean())
    if m == n or m < 2:
        return 1.0
    if p in (0.0, 1.0):
        return n / m
    between = sum((told[rows].sum() - p * len(rows)) ** 2 for rows in members) * m / (m - 1) / n**2
    return float(max(1.0, between / (p * (1.0 - p) / n)))
