"""Where to start: lines and circles through edge points and their normals.

On a circle of signed curvature k (positive where the material is inside) the unit normal into the material at p
is n = k (c - p).  So k is minus the slope of normals over points, c = mean(p) + mean(n)/k, and noise in the
normals does not bend it, points being sharp (our derivation).  Chains of neighboring points whose normals agree
are the outline's pieces.
"""

from math import atan2, cos, sin

import numba
import numpy as np

from exploration.sensing.lines.edges import EdgePoints
from exploration.sensing.lines.line import normalized
from primitives.arrays import Bools, Floats, Ints

LINK = 1.7  # [pitch] between neighbors of a chain
TURN = 0.5  # cosine between their normals
LEAST = 4  # points of a chain

Circle = tuple[float, float, float, float]  # x, y, radius [mm], +1 boss or -1 hole
Straight = tuple[float, float, float]  # angle [rad], offset [mm], material side


@numba.njit(cache=True, error_model="numpy")
def _chains(points: Floats, directions: Floats, link: float) -> Ints:
    """(n,) the number of each point's chain."""
    n = len(points)
    chain = np.full(n, -1)
    stack = np.empty(n, dtype=np.int64)
    count = 0
    for seed in range(n):
        if chain[seed] >= 0:
            continue
        chain[seed] = count
        stack[0] = seed
        top = 1
        while top:
            top -= 1
            i = stack[top]
            for j in range(n):
                if chain[j] >= 0:
                    continue
                near = np.hypot(points[i, 0] - points[j, 0], points[i, 1] - points[j, 1]) < link
                along = directions[i, 0] * directions[j, 0] + directions[i, 1] * directions[j, 1]
                if near and along > TURN:
                    chain[j] = count
                    stack[top] = j
                    top += 1
        count += 1
    return chain


def chains(points: EdgePoints, pitch: float) -> list[Bools]:
    """Pieces of the outline, longest first."""
    chain: Ints = _chains(points.points, points.directions, LINK * pitch)
    members = [chain == k for k in range(int(chain.max(initial=-1)) + 1)]
    return sorted((m for m in members if m.sum() >= LEAST), key=lambda m: -int(m.sum()))


def circle_through(points: EdgePoints, members: Bools, longest: float) -> Circle | None:
    """The circle of some edge points, from their normals; none where it is straighter than `longest` [mm]."""
    p, n, w = points.points[members], points.directions[members], points.weight[members]
    total = float(w.sum())
    if len(p) < 3 or total <= 0.0:
        return None
    p0, n0 = w @ p / total, w @ n / total
    spread = float(w @ np.square(p - p0).sum(axis=1))
    k = -float(w @ ((p - p0) * (n - n0)).sum(axis=1)) / max(spread, 1e-12)
    if abs(k) * longest < 1.0:
        return None
    center = p0 + n0 / k
    return float(center[0]), float(center[1]), 1.0 / abs(k), 1.0 if k > 0.0 else -1.0


@numba.njit(cache=True, error_model="numpy")
def _scatter(sums: Floats, direct: float) -> float:
    """How far points lie off one line, from their sums: across it, and in direction."""
    w = sums[0]
    if w <= 0.0:
        return 0.0
    nx, ny = sums[6], sums[7]
    size = np.sqrt(nx * nx + ny * ny)
    turn = direct * 2.0 * (w - size)
    sxx = sums[3] - sums[1] * sums[1] / w
    sxy = sums[4] - sums[1] * sums[2] / w
    syy = sums[5] - sums[2] * sums[2] / w
    nx, ny = nx / (size + 1e-12), ny / (size + 1e-12)
    return float(turn + nx * nx * sxx + 2.0 * nx * ny * sxy + ny * ny * syy)


@numba.njit(cache=True, error_model="numpy")
def _split(points: Floats, directions: Floats, weight: Floats, count: int, reach: float) -> Ints:
    """(n,) which of `count` lines each point is on: the cuts of the circle of directions that scatter least."""
    n = len(points)
    order = np.argsort(np.arctan2(directions[:, 1], directions[:, 0]))
    total = np.zeros((2 * n + 1, 8))
    for i in range(2 * n):
        k = order[i % n]
        x, y, w = points[k, 0], points[k, 1], weight[k]
        total[i + 1] = total[i] + w * np.array(
            [1.0, x, y, x * x, x * y, y * y, directions[k, 0], directions[k, 1]]
        )
    cost = np.empty((n, n + 1))
    direct = reach * reach
    for i in range(n):
        for size in range(n + 1):
            cost[i, size] = _scatter(total[i + size] - total[i], direct)
    best = np.inf
    first = second = third = 0
    for i in range(n):
        for j in range(i + 2, n):
            if count == 2:
                value = cost[i, j - i] + cost[j, n - j + i]
                if n - j + i >= 2 and value < best:
                    best, first, second, third = value, i, j, j
                continue
            for k in range(j + 2, n):
                value = cost[i, j - i] + cost[j, k - j] + cost[k, n - k + i]
                if n - k + i >= 2 and value < best:
                    best, first, second, third = value, i, j, k
    group = np.zeros(n, dtype=np.int64)
    if best < np.inf:
        for place in range(n):
            here = 0
            if first <= place < second:
                here = 1
            elif second <= place < third:
                here = 2
            group[order[place]] = here
    return group


def split_lines(points: EdgePoints, count: int, reach: float) -> list[Straight]:
    """So many lines through the edge points, told apart by their normals; fewer points make none."""
    if len(points) < 2 * count:
        return []
    group = _split(points.points, points.directions, points.weight, count, reach)
    found = [_straight(points, group == k) for k in range(count)]
    return [line for line in found if line is not None]


def _straight(points: EdgePoints, members: Bools) -> Straight | None:
    w = points.weight[members]
    if len(w) < 2 or not w.sum() > 0.0:
        return None
    nx, ny = w @ points.directions[members]
    cx, cy = w @ points.points[members] / w.sum()
    angle = atan2(-nx, ny)
    angle, offset, side = normalized(angle, float(cy * cos(angle) - cx * sin(angle)), 1)
    return angle, offset, float(side)


def tangents(circle: Circle, from_: float, to: float, count: int) -> list[Straight]:
    """Lines that stand for an arc from one angle [rad] to another: tangents at the middles of its parts."""
    x, y, radius, sign = circle
    part = (to - from_) / count
    away = radius * (1.0 - part * part / 24.0)
    found = []
    for i in range(count):
        turn = from_ + (i + 0.5) * part
        inward = -sign * cos(turn), -sign * sin(turn)
        at = x + away * cos(turn), y + away * sin(turn)
        angle = atan2(-inward[0], inward[1])
        angle, offset, side = normalized(angle, at[1] * cos(angle) - at[0] * sin(angle), 1)
        found.append((angle, offset, float(side)))
    return found
