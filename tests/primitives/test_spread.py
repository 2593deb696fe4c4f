"""A few of many points that stand for all."""

import numpy as np

from primitives.spread import spread


def test_points_that_are_spread_reach_all_round():
    points = np.random.default_rng(0).normal(size=(500, 3))
    points *= 30.0 / np.linalg.norm(points, axis=1, keepdims=True)
    kept = spread(points, 40)
    assert len(set(kept.tolist())) == 40
    gaps = [np.linalg.norm(points[kept] - p, axis=1).min() for p in points]
    among = np.linalg.norm(points[kept][:, None] - points[kept], axis=2) + 100.0 * np.eye(40)
    assert max(gaps) <= among.min()  # what is left out lies nearer than those that are kept lie to each other
    assert len(spread(points[:10], 40)) == 10
