"""Where the face beside an edge ends: what is not that edge is looked for before it is fitted.

The profile of depth along the edge, just inside it, says where the face ends ahead and behind (a corner, a rim);
just outside it, where material begins (an inside corner); the profile across it, where the face ends opposite (a
thin wall).
"""

import numba
import numpy as np

from exploration.sensing.lines.bent_edge import inside
from primitives.arrays import Floats

INSIDE = (1.0, 5.0)  # [response widths] from the edge, of the strip whose end is the face's end
OUTSIDE = (-5.0, -2.0)  # the strip in which contact means that the material goes round a corner
LEAST = 0.3  # taxels of a bin that says something


@numba.njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def face_ends(
    depth: Floats,
    sigma: Floats,
    px: float,
    py: float,
    angle: float,
    offset: float,
    side: float,
    bend: float,
    width: float,
) -> tuple[Floats, Floats, Floats, float]:
    """Where the face ends ahead, behind, begins outside, ends opposite, and how far across was looked [mm]; how
    far across it reaches in each column of a pitch along the edge, or in one beside it, the middle one at v = 0;
    the contact's area and centroid; the face's middle depth.
    """
    rows, columns = depth.shape
    ca, sa = np.cos(angle), np.sin(angle)
    pitch = max(px, py)
    reach = 0.5 * np.hypot(rows * py, columns * px)
    bins = 2 * int(np.ceil(reach / pitch)) + 3
    middle = bins // 2
    inner, n_inner = np.zeros(bins), np.zeros(bins)
    outer, n_outer = np.zeros(bins), np.zeros(bins)
    across, n_across = np.zeros(2 * bins), np.zeros(2 * bins)
    level, n_level = np.zeros(2), np.zeros(2)  # behind and ahead: the face may end within either
    for i in range(rows):
        y = (i - (rows - 1) / 2) * py
        for j in range(columns):
            if sigma[i, j] == np.inf:
                continue
            x = (j - (columns - 1) / 2) * px
            v = ca * x + sa * y
            t = inside(side * (ca * y - sa * x - offset), v, bend)[0] / width
            if INSIDE[0] < t < INSIDE[1]:
                _shared(inner, n_inner, middle + v / pitch, depth[i, j])
                if abs(v) < 2.0 * pitch:
                    level[int(v > 0.0)] += depth[i, j]
                    n_level[int(v > 0.0)] += 1.0
            elif OUTSIDE[0] < t < OUTSIDE[1]:
                _shared(outer, n_outer, middle + v / pitch, depth[i, j])
    ends = np.full(5, np.inf)
    contact = np.zeros(3)
    touched, free = np.full(bins, -np.inf), np.full(bins, -np.inf)
    if n_level.sum() < 2.0:
        return ends, free, contact, 0.0
    middle_depth = float(np.max(level / np.maximum(n_level, 1.0)))
    half = 0.5 * middle_depth
    ends[0] = (_profile_end(inner, n_inner, middle, 1, half, True) - middle) * pitch
    ends[1] = (middle - _profile_end(inner, n_inner, middle, -1, half, True)) * pitch
    if ends[1] == -np.inf:
        ends[1] = np.inf
    ends[2] = (_profile_end(outer, n_outer, middle, 1, half, False) - middle) * pitch
    low = max(-2.5 * pitch, -ends[1] + width)
    high = min(2.5 * pitch, min(ends[0], ends[2]) - width)
    for i in range(rows):
        y = (i - (rows - 1) / 2) * py
        for j in range(columns):
            if sigma[i, j] == np.inf:
                continue
            x = (j - (columns - 1) / 2) * px
            if depth[i, j] > half:
                contact[0] += 1.0
                contact[1] += x
                contact[2] += y
            v = ca * x + sa * y
            t = inside(side * (ca * y - sa * x - offset), v, bend)[0]
            column = int(middle + v / pitch + 0.5)
            if depth[i, j] > half:
                touched[column] = max(touched[column], t)
            else:
                free[column] = max(free[column], t)
            if low < v < high:
                k = int(t / pitch)
                if t > 0.0 and k < 2 * bins:
                    across[k] += depth[i, j]
                    n_across[k] += 1.0
    peak = 0.0
    for k in range(2 * bins):
        if n_across[k] > 1.0:
            peak = max(peak, across[k] / n_across[k])
            ends[4] = (k + 1) * pitch
    half = 0.5 * peak
    ends[3] = (_profile_end(across, n_across, int(np.ceil(width / pitch)), 1, half, True) + 0.5) * pitch
    if contact[0] > 0.0:
        contact[1] /= contact[0]
        contact[2] /= contact[0]
    contact[0] *= px * py
    for k in range(bins):
        touched[k] = touched[k] + 0.5 * pitch if -np.inf < touched[k] < free[k] else np.inf
    deep = touched.copy()
    for k in range(bins):
        deep[k] = np.min(touched[max(0, k - 1) : k + 2])
    return ends, deep, contact, middle_depth


@numba.njit(cache=True, error_model="numpy")
def _shared(total: Floats, count: Floats, place: float, depth: float) -> None:
    """Give a taxel to the two bins round it, by nearness: rounding would move a column halfway by a whole bin."""
    k = int(place)
    near = place - k
    total[k] += (1.0 - near) * depth
    count[k] += 1.0 - near
    total[k + 1] += near * depth
    count[k + 1] += near


@numba.njit(cache=True, error_model="numpy")
def _profile_end(total: Floats, count: Floats, start: int, step: int, level: float, falling: bool) -> float:
    """The bin, between bins, at which the mean passes `level` going from `start`; inf if it never does."""
    last = np.nan
    k = start
    while 0 <= k < len(total):
        if count[k] > LEAST:
            mean = total[k] / count[k]
            if (mean < level) == falling:
                if np.isnan(last):
                    return float(k)
                return float(k - step * (level - mean) / (last - mean))
            last = mean
        k += step
    return np.inf
