"""Where a pad may lie so that much of a face's open surface is under it; the best place first."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from exploration.planning.open.frontier import Predicted
from exploration.planning.ways.box_kernels import in_box
from primitives import pose as se3
from primitives.arrays import Floats

_SHIFTS = (0.0, 0.5, -0.5, 0.9, -0.9)  # of half the pad, aside
_RIM = 1.0  # [mm] of the pad that covers nothing
_UNDER = 2.0  # [mm] off the pad's plane, that is still under it


def lying_places(
    left: Predicted, one: int, alongs: Sequence[Floats], size: tuple[float, float]
) -> list[Floats]:
    """(4, 4) poses of a pad of a `size` [mm] over `one` of the open places, x along one of `alongs`."""
    point, normal, face = left.points[one], left.normals[one], left.face[one]
    hx, hy = (0.5 * np.asarray(size) - _RIM).tolist()
    low, high, points = (-hx, -hy, -_UNDER), (hx, hy, _UNDER), left.points[left.face == face]
    best: list[tuple[float, Floats]] = []
    for along in alongs:
        turn = se3.frame_along(-normal, along)
        for sx in _SHIFTS:
            for sy in _SHIFTS:
                pose = se3.pose(turn, point + turn @ np.array([sx * hx, sy * hy, 0.0]))
                under = in_box(points, pose, low, high)
                best.append((-float(under.sum()) + 0.1 * float(np.hypot(sx, sy)), pose))
    return [pose for _, pose in sorted(best, key=lambda item: item[0])]
