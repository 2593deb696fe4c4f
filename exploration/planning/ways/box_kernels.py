"""Which of many points lie in a posed box, the poses along a way, which of them hold none, and are near to others.

All but the first are asked for every step of every way that is looked at.  Along a way most points are never near:
those outside the upright box about all that a box passes through are left out at once.
"""

from collections.abc import Sequence

import numba
import numpy as np

from primitives.arrays import Bools, Floats


def in_box(points: Floats, pose: Floats, low: Sequence[float], high: Sequence[float]) -> Bools:
    """(n,) which of (n, 3) points lie in a box with given corners [mm] in the frame of a (4, 4) pose."""
    return np.asarray(_in_box(points, pose, np.array(low, dtype=float), np.array(high, dtype=float)))


@numba.njit(cache=True, error_model="numpy")
def _in_box(points: Floats, pose: Floats, low: Floats, high: Floats) -> Bools:
    out = np.empty(len(points), dtype=np.bool_)
    for n in range(len(points)):
        x, y, z = points[n, 0] - pose[0, 3], points[n, 1] - pose[1, 3], points[n, 2] - pose[2, 3]
        out[n] = True
        for i in range(3):
            out[n] &= low[i] < pose[0, i] * x + pose[1, i] * y + pose[2, i] * z < high[i]
    return out


@numba.njit(cache=True, error_model="numpy")
def swung(start: Floats, goal: Floats, mount: Floats, turn: Floats, count: int) -> Floats:
    """(count, 4, 4) poses of what a stage carries on a (4, 4) `mount` while its flange goes straight to a goal.

    The flange turns by the rotation vector `turn` (3,) meanwhile, evenly.
    """
    out = np.empty((count, 4, 4))
    back = np.linalg.inv(mount)
    a, b = start @ back, goal @ back
    angle = np.sqrt((turn**2).sum())
    hat = np.zeros((3, 3))
    if angle > 0.0:
        x, y, z = turn[0] / angle, turn[1] / angle, turn[2] / angle
        hat[0, 1], hat[0, 2], hat[1, 0], hat[1, 2], hat[2, 0], hat[2, 1] = -z, y, z, -x, -y, x
    squared = hat @ hat
    first, flange = a[:3, :3].copy(), np.eye(4)
    for k in range(count):
        share = k / (count - 1.0)
        turned = np.eye(3) + np.sin(share * angle) * hat + (1.0 - np.cos(share * angle)) * squared
        flange[:3, :3] = turned @ first
        flange[:3, 3] = a[:3, 3] + share * (b[:3, 3] - a[:3, 3])
        out[k] = flange @ mount
    return out


@numba.njit(cache=True, error_model="numpy")
def free_of(poses: Floats, points: Floats, places: Floats, low: Floats, high: Floats) -> Bools:
    """(k,) whether none of (n, 3) points lies in any of b boxes that are moved to (k, 4, 4) poses.

    `places` (b, 4, 4) are where the boxes are in the moved frame, `low` and `high` (b, 3) their corners [mm].
    """
    out = np.ones(len(poses), dtype=np.bool_)
    there = np.empty((len(poses), 3, 4))
    for b in range(len(places)):
        for k in range(len(poses)):
            for i in range(3):
                for j in range(4):
                    there[k, i, j] = poses[k, i, 3] if j == 3 else 0.0
                    for m in range(3):
                        there[k, i, j] += poses[k, i, m] * places[b, m, j]
        near = _passed(there, points, low[b], high[b])
        for k in range(len(poses)):
            if out[k] and _holds(there[k], near, low[b], high[b]):
                out[k] = False
    return out


@numba.njit(cache=True, error_model="numpy")
def comes_near(
    start: Floats, poses: Floats, others: Floats, reach: float, turn: float, leading_off: float
) -> bool:
    """Whether one of (k, 4, 4) poses is near to one of (n, 4, 4) others, and nearer than the start was.

    Near is within `reach` [mm] and within `turn` in each element of the attitude's matrix; nearer is by more than
    `leading_off` of these.
    """
    for n in range(len(others)):
        limit = min(1.0, _apart(start, others[n], reach, turn) - leading_off)
        for k in range(len(poses)):
            if _apart(poses[k], others[n], reach, turn) < limit:
                return True
    return False


@numba.njit(cache=True, error_model="numpy")
def _apart(a: Floats, b: Floats, reach: float, turn: float) -> float:
    """How far two (4, 4) poses are apart, 1 being where they are no longer near."""
    most, square = 0.0, 0.0
    for i in range(3):
        square += (a[i, 3] - b[i, 3]) ** 2
        for j in range(3):
            most = max(most, abs(a[i, j] - b[i, j]))
    return float(max(np.sqrt(square) / reach, most / turn))


@numba.njit(cache=True, error_model="numpy")
def _passed(poses: Floats, points: Floats, low: Floats, high: Floats) -> Floats:
    """Those of (n, 3) points that lie in the upright box about one box at all of (k, 3, 4) poses."""
    first, last = np.full(3, np.inf), np.full(3, -np.inf)
    for k in range(len(poses)):
        for i in range(3):
            middle, half = poses[k, i, 3], 0.0
            for j in range(3):
                middle += poses[k, i, j] * 0.5 * (low[j] + high[j])
                half += abs(poses[k, i, j]) * 0.5 * (high[j] - low[j])
            first[i], last[i] = min(first[i], middle - half), max(last[i], middle + half)
    near, count = np.empty((len(points), 3)), 0
    for n in range(len(points)):
        x, y, z = points[n, 0], points[n, 1], points[n, 2]
        if first[0] <= x <= last[0] and first[1] <= y <= last[1] and first[2] <= z <= last[2]:
            near[count, 0], near[count, 1], near[count, 2] = x, y, z
            count += 1
    return near[:count]


@numba.njit(cache=True, error_model="numpy")
def _holds(pose: Floats, points: Floats, low: Floats, high: Floats) -> bool:
    """Whether one of (n, 3) points lies in one box at a (3, 4) pose."""
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
