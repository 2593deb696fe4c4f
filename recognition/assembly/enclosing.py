"""The least circle round points in a plane (Welzl 1991, without recursion: a point outside grows the circle)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from primitives.arrays import Floats

_SLACK = 1e-9  # of the radius, within which a point is in the circle


def enclosing_circle(points: Floats) -> tuple[Floats, float]:
    """Center (2,) and radius of the least circle that holds (n, 2) points, n at least 1."""
    order = points[np.random.default_rng(0).permutation(len(points))]
    return _round(order, ())


def _round(points: Floats, on: Sequence[Floats]) -> tuple[Floats, float]:
    """Of points, some given ones on its rim."""
    center, radius = _through(on) if on else (points[0], 0.0)
    for k, point in enumerate(points):
        if float(np.hypot(*(point - center))) > radius * (1.0 + _SLACK) + 1e-12:
            center, radius = _round(points[:k], (*on, point)) if len(on) < 2 else _through((*on, point))
    return center, radius


def _through(on: Sequence[Floats]) -> tuple[Floats, float]:
    """The least circle with one, two or three points on its rim."""
    if len(on) == 1:
        return on[0], 0.0
    if len(on) == 2:
        return 0.5 * (on[0] + on[1]), 0.5 * float(np.hypot(*(on[1] - on[0])))
    arms = np.array([on[1] - on[0], on[2] - on[0]])
    offset, *_ = np.linalg.lstsq(arms, 0.5 * (arms**2).sum(axis=1), rcond=None)
    return on[0] + offset, float(np.hypot(*offset))
