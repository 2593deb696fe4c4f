"""Where to start: circles through edge points and their normals, and what a face leaves unexplained.

On a circle of signed curvature k (positive where the material is inside) the unit normal into the material at p
is n = k (c - p).  So k is minus the slope of normals over points, c = mean(p) + mean(n)/k, and noise in the
normals does not bend it, points being sharp (our derivation).  Chains of neighboring points whose normals agree
are the outline's pieces.
"""

from math import hypot

import numba
import numpy as np

from exploration.sensing.lines.edges import EdgePoints
from exploration.sensing.lines.line import clipped
from exploration.sensing.lines.region import Region
from primitives.arrays import Bools, Floats, Ints

LINK = 1.7  # [pitch] between neighbors of a chain
TURN = 0.5  # cosine between their normals
LEAST = 4  # points of a chain
SAMPLES = 96  # along a line or a circle, where it is asked what of it is seen
BESIDE = 0.05  # [mm]

Circle = tuple[float, float, float, float]  # x, y, radius [mm], +1 boss or -1 hole


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


def blob(depth: Floats, x: Floats, y: Floats, variance: Floats) -> Circle | None:
    """The disc whose blur has the first two moments of an image; none where it has no volume."""
    total = float(depth.sum())
    if total <= 0.0:
        return None
    along, across = depth.sum(axis=0), depth.sum(axis=1)
    cx, cy = float(along @ x) / total, float(across @ y) / total
    vx, vy = float(along @ (x - cx) ** 2) / total, float(across @ (y - cy) ** 2) / total
    radius = 2.0 * max(0.5 * (vx + vy - float(variance.sum())), 0.0) ** 0.5
    return cx, cy, max(radius, 0.3 * float(variance.mean()) ** 0.5), 1.0


def seen_of_line(
    region: Region, parameters: Floats, angle: float, offset: float, size: tuple[float, float]
) -> tuple[float, float]:
    """The stretch [mm] along a line where the face ends at it, on a pad of this size; (0, 0) if nowhere."""
    low, high = clipped(angle, offset, (size[0] / 2, size[1] / 2))
    if high <= low:
        return 0.0, 0.0
    e = np.array([np.cos(angle), np.sin(angle)])
    n = np.array([-e[1], e[0]])
    along = low + (np.arange(SAMPLES) + 0.5) * (high - low) / SAMPLES
    at = along[:, None] * e + offset * n
    border = region.holds(at + BESIDE * n, parameters) != region.holds(at - BESIDE * n, parameters)
    if not border.any():
        return 0.0, 0.0
    half = 0.5 * (high - low) / SAMPLES
    return float(along[border][0]) - half, float(along[border][-1]) + half


def seen_of_disc(
    region: Region, parameters: Floats, disc: Floats, size: tuple[float, float]
) -> tuple[float, Floats]:
    """The angle [rad] of a circle that the pad sees as the face's end, and (2,) the middle of it."""
    cx, cy, radius = disc.tolist()
    if hypot(cx, cy) + hypot(*size) / 2 > 3 * radius:
        low, high = -np.pi, np.pi
    else:
        toward = np.arctan2(-cy, -cx)
        half = min(np.pi, 1.2 * hypot(*size) / radius)
        low, high = toward - half, toward + half
    turn = low + (np.arange(SAMPLES) + 0.5) * (high - low) / SAMPLES
    out = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    at = disc[:2] + radius * out
    on_pad = (np.abs(at[:, 0]) < size[0] / 2) & (np.abs(at[:, 1]) < size[1] / 2)
    beside = region.holds(at + BESIDE * out, parameters) != region.holds(at - BESIDE * out, parameters)
    border = on_pad & beside
    if not border.any():
        return 0.0, disc[:2]
    return float(border.mean()) * (high - low), at[border].mean(axis=0)
