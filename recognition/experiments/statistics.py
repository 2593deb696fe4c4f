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
from scipy.special import ndtri, stdtrit

from primitives.arrays import Floats, Ints

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
    z = float(ndtri(0.5 + level / 2.0))
    middle = (right + z * z / 2.0) / (count + z * z)
    half = z * np.sqrt(right * (count - right) / count + z * z / 4.0) / (count + z * z)
    return max(0.0, float(middle - half)), min(1.0, float(middle + half))


def share(
    right: Sequence[bool], units: Sequence[Unit] | None = None, level: float = LEVEL
) -> Estimate | None:
    """How many were right; None of nothing."""
    if not len(right):
        return None
    told, members = _sample(right, units)
    n, p, design = len(told), float(told.mean()), _design(told, members)
    return _estimate(p, wilson(p * n / design, n / design, level), told, members)


def median(
    values: Sequence[float], units: Sequence[Unit] | None = None, level: float = LEVEL
) -> Estimate | None:
    """The middle of the values; None of nothing."""
    if not len(values):
        return None
    told, members = _sample(values, units)
    middle = float(np.median(told))
    if len(members) == 1:
        return _estimate(middle, None, told, members)
    drawn = np.random.default_rng(0).integers(0, len(members), (DRAWS, len(members)))
    if all(len(rows) == 1 for rows in members):
        medians = np.median(told[drawn], axis=1)
    else:
        medians = np.array([np.median(told[np.concatenate([members[k] for k in draw])]) for draw in drawn])
    low, high = np.quantile(medians, [0.5 - level / 2.0, 0.5 + level / 2.0])
    return _estimate(middle, (float(low), float(high)), told, members)


def mean_of_units(
    values: Sequence[float], units: Sequence[Unit] | None = None, level: float = LEVEL
) -> Estimate | None:
    """The mean over units of their means, with Student's interval; None of nothing."""
    if not len(values):
        return None
    told, members = _sample(values, units)
    means = np.array([told[rows].mean() for rows in members])
    middle = float(means.mean())
    if len(means) < 2:
        return _estimate(middle, None, told, members)
    half = float(stdtrit(len(means) - 1, 0.5 + level / 2.0) * means.std(ddof=1) / np.sqrt(len(means)))
    return _estimate(middle, (middle - half, middle + half), told, members)


def _estimate(
    value: float, interval: tuple[float, float] | None, told: Floats, members: list[Ints]
) -> Estimate:
    low, high = interval or (None, None)
    return Estimate(value, low, high, len(told), len(members))


def _sample(values: Sequence[float], units: Sequence[Unit] | None) -> tuple[Floats, list[Ints]]:
    """The values, and the rows of each unit; each row is its own where units are not told."""
    told = np.asarray(values, dtype=float)
    rows: dict[Unit, list[int]] = {}
    for row, unit in enumerate(range(len(told)) if units is None else units):
        rows.setdefault(unit, []).append(row)
    return told, [np.array(mine) for mine in rows.values()]


def _design(told: Floats, members: list[Ints]) -> float:
    """By how much trials of one unit count less than trials of different ones."""
    n, m, p = len(told), len(members), float(told.mean())
    if m == n or m < 2:
        return 1.0
    if p in (0.0, 1.0):
        return n / m
    between = sum((told[rows].sum() - p * len(rows)) ** 2 for rows in members) * m / (m - 1) / n**2
    return float(max(1.0, between / (p * (1.0 - p) / n)))
