"""Which poses of a set of boxes hold one of many points: asked for every step of every way that is looked at."""

import numba
import numpy as np

from primitives.arrays import Bools, Floats


@numba.njit(cache=True, error_model="numpy")
def free_of(poses: Floats, points: Floats, places: Floats, low: Floats, high: Floats) -> Bools:
    """(k,) whether none of (n, 3) points lies in any of b boxes that are moved to (k, 4, 4) poses.

    `places` (b, 4, 4) are where the boxes are in the moved frame, `low` and `high` (b, 3) their corners [mm].
    """
    out = np.ones(len(poses), dtype=np.bool_)
    there = np.empty((4, 4))
    for k in range(len(poses)):
        for b in range(len(places)):
            for i in range(3):
                for j in range(4):
                    there[i, j] = poses[k, i, 3] if j == 3 else 0.0
                    for m in range(3):
                        there[i, j] += poses[k, i, m] * places[b, m, j]
            if _holds(there, points, low[b], high[b]):
                out[k] = False
                break
    return out


@numba.njit(cache=True, error_model="numpy")
def _holds(pose: Floats, points: Floats, low: Floats, high: Floats) -> bool:
    """Whether one of (n, 3) points lies in one box at a (4, 4) pose."""
    for n in range(len(points)):
        x, y, z = points[n, 0] - pose[0, 3], points[n, 1] - pose[1, 3], points[n, 2] - pose[2, 3]
        inside = True
        for i in range(3):
            at = pose[0, i] * x + pose[1, i] * y + pose[2, i] * z
            if not low[i] < at < high[i]:
                inside = False
                break
        if inside:
            return True
    return False
