"""A few of many points that stand for all: each the farthest from those before it."""

from __future__ import annotations

import numpy as np

from primitives.arrays import Floats, Ints


def spread(points: Floats, most: int) -> Ints:
    """(m,) rows of at most so many of (n, k) points, the first the farthest from their middle; of no more, all."""
    if len(points) <= most:
        return np.arange(len(points))
    chosen = [int(np.argmax(np.linalg.norm(points - points.mean(axis=0), axis=1)))]
    away = np.linalg.norm(points - points[chosen[0]], axis=1)
    while len(chosen) < most:
        chosen.append(int(away.argmax()))
        away = np.minimum(away, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return np.array(chosen)
