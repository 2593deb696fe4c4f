"""From which frame on each point that was felt is shown: the first whose pad lay on it.

A page shows a choice of the frames, so a point may have been felt between two of them; it then comes with the
frame whose pad came nearest.
"""

from __future__ import annotations

import numpy as np

from primitives.arrays import Bools, Floats, Ints

_NEAR = 2.0  # [mm] beside the pad or off its skin, within which a point was felt by it


def felt_from(points: Floats, poses: Floats, touching: Bools, pad: tuple[float, float]) -> Ints:
    """(n,) the frame with which each of (n, 3) points comes; 0 where none of the frames touches.

    `poses` (m, 4, 4) are world_from_sensor of the frames, and `touching` (m,) says which of them are in contact.
    """
    best = np.full(len(points), np.inf)
    out = np.zeros(len(points), dtype=np.int64)
    half = np.array([pad[0] / 2.0, pad[1] / 2.0, 0.0])
    open_ = np.arange(len(points))
    for number in np.flatnonzero(touching).tolist():
        pose = poses[number]
        local = (points[open_] - pose[:3, 3]) @ pose[:3, :3]
        away = np.maximum(np.abs(local) - half, 0.0).max(axis=1)
        nearer = away < best[open_]
        best[open_[nearer]], out[open_[nearer]] = away[nearer], number
        open_ = open_[away > _NEAR]
        if not len(open_):
            break
    return out
