"""Votes of edge points for lines: an adaptive Hough transform, modified.

Illingworth and Kittler's adaptive transform votes in a small accumulator and zooms on its peak.  Modified, by our
derivation: (rho, theta) is bounded to the pad and wraps, (theta - pi, -rho) being the same line; the next window
is three cells of the last, centered on the peak, so windows overlap and a peak on a cell's border is never
split; each edge point votes with its evidence (sharpness, sub-taxel position, its gradient's direction) and
shares the vote between the nearest cells; the line found takes its points away, and the vote is repeated.
"""

import numba
import numpy as np

from primitives.arrays import Bools, Floats

ANGLES, OFFSETS = 12, 15  # cells of the first accumulator
WINDOW = 9  # cells an axis of each zoom
ZOOMS = 3  # each three times finer


@numba.njit(cache=True, error_model="numpy")
def members_of(
    points: Floats,
    directions: Floats,
    weight: Floats,
    angle: float,
    offset: float,
    band: float,
    tolerance: float,
) -> tuple[Bools, float, float, float]:
    """Which points lie on a line, their votes, the length they span, and on which side their material is."""
    ca, sa = np.cos(angle), np.sin(angle)
    members = np.zeros(len(points), dtype=np.bool_)
    toward = 0.0
    for k in range(len(points)):
        if weight[k] > 0.0 and abs(-sa * points[k, 0] + ca * points[k, 1] - offset) < band:
            cosine = -sa * directions[k, 0] + ca * directions[k, 1]
            if abs(cosine) > np.cos(tolerance):
                members[k] = True
                toward += weight[k] * cosine
    votes = 0.0
    low, high = np.inf, -np.inf
    for k in range(len(points)):
        if members[k]:
            cosine = -sa * directions[k, 0] + ca * directions[k, 1]
            if cosine * toward < 0.0:
                members[k] = False
                continue
            votes += weight[k]
            v = ca * points[k, 0] + sa * points[k, 1]
            low, high = min(low, v), max(high, v)
    return members, votes, max(0.0, high - low), toward


@numba.njit(cache=True, error_model="numpy")
def _vote(
    points: Floats,
    directions: Floats,
    weight: Floats,
    angles: Floats,
    first: float,
    step: float,
    tolerance: float,
    cells: Floats,
) -> None:
    cells[:] = 0.0
    count = cells.shape[1]
    for a in range(len(angles)):
        ca, sa = np.cos(angles[a]), np.sin(angles[a])
        for k in range(len(points)):
            if weight[k] <= 0.0:
                continue
            cosine = abs(-sa * directions[k, 0] + ca * directions[k, 1])
            share = 1.0 - np.sqrt(max(0.0, 2.0 - 2.0 * cosine)) / tolerance
            if share <= 0.0:
                continue
            place = (-sa * points[k, 0] + ca * points[k, 1] - first) / step
            if place <= -1.0 or place >= count:
                continue
            i = int(np.floor(place))
            f = place - i
            if i >= 0:
                cells[a, i] += weight[k] * share * (1.0 - f)
            if i + 1 < count:
                cells[a, i + 1] += weight[k] * share * f


@numba.njit(cache=True, error_model="numpy")
def find_peak(
    points: Floats, directions: Floats, weight: Floats, reach: float, tolerance: float
) -> tuple[float, float]:
    """Angle and offset where most evidence meets."""
    angle_step, step = np.pi / ANGLES, 2.0 * reach / OFFSETS
    angles = (np.arange(ANGLES) + 0.5) * angle_step
    cells = np.zeros((ANGLES, OFFSETS))
    first = -reach + 0.5 * step
    _vote(points, directions, weight, angles, first, step, tolerance, cells)
    best = np.argmax(cells)
    angle, offset = angles[best // OFFSETS], first + (best % OFFSETS) * step
    window = np.zeros((WINDOW, WINDOW))
    for _ in range(ZOOMS):
        angle_step /= 3.0
        step /= 3.0
        for _shift in range(2):
            angles = angle + (np.arange(WINDOW) - WINDOW // 2) * angle_step
            first = offset - (WINDOW // 2) * step
            _vote(points, directions, weight, angles, first, step, tolerance, window)
            best = np.argmax(window)
            i, j = best // WINDOW, best % WINDOW
            angle, offset = angles[i], first + j * step
            if 0 < i < WINDOW - 1 and 0 < j < WINDOW - 1:
                break
    return angle, offset
