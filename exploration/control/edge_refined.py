"""A bent edge once more, from every taxel beside it: each says where the edge runs at its own foot point.

A frame's fit takes the edge to be one arc as far as it looks, and errs where the bend changes.  Once a curve is
known nearly, no arc is needed.  A taxel t inside it, whose foot lies at the place s along it, should read

    D(t) = A edge(u / w) + b w ramp(u / w),   u = t - kappa w^2 / 2,

with the face's depth A and slope b as the frames about it were fitted, w the response's width and kappa the
curve's bend there (blurring a bent edge moves its half height toward the hollow side).  What it reads else, over
D', is how far the edge lies further out there.  All frames' taxels are averaged at nodes along the curve, each
by its information D'^2 / sigma^2, and the nodes are moved by the mean: one Gauss-Newton step of the curve that
explains all frames at once (our derivation).
"""

from dataclasses import dataclass

import numba
import numpy as np
from scipy.ndimage import uniform_filter1d

from exploration.sensing.response import Response, look_up
from exploration.sensing.surfaces.normal_equations import HUBER
from primitives.arrays import Floats


@dataclass(frozen=True)
class RefinedConfig:
    """How much of a frame speaks for the curve."""

    spacing: float = 0.5  # [mm] of the nodes
    along: float = 6.0  # [mm] along the edge from the pad's center, either way
    beside: float = 2.0  # [response widths] across the edge, either way
    about: int = 21  # ticks, over which the face's depth and slope hardly change
    bend_over: int = 3  # nodes either way, over which the bend is taken


@dataclass(frozen=True)
class Frames:
    """What a curve is compared with."""

    depth: Floats  # (n, rows, columns) [mm]
    sigma: Floats  # (n, rows, columns) [mm]
    pitch: tuple[float, float]  # [mm]
    poses: Floats  # (n, 4, 4) world_from_sensor
    faces: Floats  # (n, 2) depth of the face at the edge [mm], and its slope inward
    side: float  # of the material, +1 to the left of travel
    places: Floats  # (n,) [mm] of the pad's center along the curve


def nodes_along(first: float, last: float, config: RefinedConfig = RefinedConfig()) -> Floats:
    """(m,) [mm] places of the nodes."""
    return np.linspace(first, last, max(2, round((last - first) / config.spacing) + 1))


def moved_outward(
    curve: Floats, frames: Frames, first: float, response: Response, config: RefinedConfig = RefinedConfig()
) -> tuple[Floats, Floats]:
    """(m,) [mm] by which each of the (m, 3) nodes of a curve should go outward, and its information [1/mm^2].

    The first node lies at the place `first` [mm], the others `spacing` apart.
    """
    steps = np.linalg.norm(np.diff(curve, axis=0), axis=1)
    sums = np.zeros((len(curve), 2))
    _compared(
        curve,
        float(steps.mean()),
        first,
        frames.depth,
        frames.sigma,
        frames.pitch,
        frames.poses,
        uniform_filter1d(frames.faces, config.about, axis=0, mode="nearest"),
        frames.side,
        frames.places,
        response.table,
        response.variance,
        (config.along, config.beside, config.bend_over),
        sums,
    )
    known = sums[:, 0] > 0.0
    return np.where(known, sums[:, 1] / np.where(known, sums[:, 0], 1.0), 0.0), sums[:, 0]


@numba.njit(cache=True, error_model="numpy")
def _compared(
    curve: Floats,
    step: float,
    first: float,
    depth: Floats,
    sigma: Floats,
    pitch: tuple[float, float],
    poses: Floats,
    faces: Floats,
    side: float,
    places: Floats,
    table: Floats,
    variance: Floats,
    reach: tuple[float, float, int],
    sums: Floats,
) -> None:
    """Add every frame's taxels to the nodes' information, and to that times how far outward the edge lies."""
    along, beside, over = reach
    frames, rows, columns = depth.shape
    count = len(curve)
    x, y = np.empty(count), np.empty(count)
    for f in range(frames):
        middle = round((places[f] - first) / step)
        spread = int(np.ceil(1.5 * along / step))
        low, high = max(0, middle - spread), min(count, middle + spread + 1)
        if high - low < 2 * over + 2:
            continue
        pose = poses[f]
        for m in range(low, high):
            x[m] = y[m] = 0.0
            for i in range(3):
                away = curve[m, i] - pose[i, 3]
                x[m] += pose[i, 0] * away
                y[m] += pose[i, 1] * away
        for r in range(rows):
            py = (r - (rows - 1) / 2) * pitch[1]
            for c in range(columns):
                if sigma[f, r, c] == np.inf:
                    continue
                px = (c - (columns - 1) / 2) * pitch[0]
                m, share = _foot(x, y, low, high, px, py)
                if m < 0 or abs((m + share) * step + first - places[f]) > along:
                    continue
                tx, ty = x[m + 1] - x[m], y[m + 1] - y[m]
                length = np.hypot(tx, ty)
                tx, ty = tx / length, ty / length
                width = np.sqrt(variance[0] * ty * ty + variance[1] * tx * tx)
                t = side * (tx * (py - y[m]) - ty * (px - x[m]))
                if abs(t) > beside * width:
                    continue
                bend = side * _bend(x, y, min(max(m, low + over), high - 1 - over), over)
                u = (t - 0.5 * bend * width * width) / width
                line, edge, ramp = look_up(table, u, 0)
                slope = faces[f, 0] * line / width + faces[f, 1] * edge
                if slope <= 0.0:
                    continue
                off = depth[f, r, c] - faces[f, 0] * edge - faces[f, 1] * width * ramp
                weight = (slope / sigma[f, r, c]) ** 2
                size = abs(off) / sigma[f, r, c]
                if size > HUBER:
                    weight *= HUBER / size
                node = m + int(share > 0.5)  # one only: the nodes' noise must not be shared
                sums[node, 0] += weight
                sums[node, 1] += weight * off / slope


@numba.njit(cache=True, error_model="numpy")
def _foot(x: Floats, y: Floats, low: int, high: int, px: float, py: float) -> tuple[int, float]:
    """The segment nearest to a point, and the share of it at the point's foot; -1 where that is an end."""
    nearest, best = np.inf, low
    for m in range(low, high):
        square = (px - x[m]) ** 2 + (py - y[m]) ** 2
        if square < nearest:
            nearest, best = square, m
    for m in (best - 1, best):
        if m < low or m + 1 >= high:
            continue
        dx, dy = x[m + 1] - x[m], y[m + 1] - y[m]
        share = ((px - x[m]) * dx + (py - y[m]) * dy) / (dx * dx + dy * dy)
        if 0.0 <= share <= 1.0:
            return m, share
    return (best, 0.0) if low < best < high - 1 else (-1, 0.0)


@numba.njit(cache=True, error_model="numpy")
def _bend(x: Floats, y: Floats, m: int, over: int) -> float:
    """[1/mm] the curve's bend about a node, positive to the left."""
    ax, ay = x[m] - x[m - over], y[m] - y[m - over]
    bx, by = x[m + over] - x[m], y[m + over] - y[m]
    cx, cy = ax + bx, ay + by
    sides = np.sqrt((ax * ax + ay * ay) * (bx * bx + by * by) * (cx * cx + cy * cy))
    return float(2.0 * (ax * by - ay * bx) / sides)
