"""Swept boxes, against plain numpy."""

import numpy as np

from primitives import pose as se3
from primitives.evidence import FreeSpace


def test_boxes_that_hold_points_are_counted_one_by_one():
    rng = np.random.default_rng(2)
    poses = np.array(
        [se3.exp(np.concatenate([rng.normal(0, 30, 3), rng.normal(0, 1, 3)])) for _ in range(40)]
    )
    halves, points = rng.uniform(3.0, 20.0, (40, 3)), rng.normal(0.0, 20.0, (300, 3))
    boxes = FreeSpace(poses, halves)
    held = [FreeSpace(poses[k : k + 1], halves[k : k + 1]).contains(points, 1.0).sum() for k in range(40)]
    local = np.einsum("bji,pbj->pbi", poses[:, :3, :3], points[:, None] - poses[:, :3, 3])
    inside = (np.abs(local) <= halves - 1.0).all(axis=2)
    assert np.array_equal(inside.sum(axis=0), held)
    assert boxes.passed(points, 1.0, 3, 99) == sum(count >= 3 for count in held) > 4
    assert boxes.passed(points, 1.0, 3, 4) == 4
