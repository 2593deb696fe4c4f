"""The soft pictures that polygons give, and how these change as their corners move.

Cell (i, j) of a picture has its middle at step (i, j); its value is the share of it that lies inside, softened by
a Gaussian.  An edge that moves out by d adds d N2(x - e; soft) per mm of it to the picture at x (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence

import numba
import numpy as np
from scipy.ndimage import gaussian_filter

from primitives.arrays import Bools, Floats, Ints

REACH = 3.0  # times what a picture is soft by, from an outline, within which the picture tells of it


def drawn(rims: Sequence[Floats], shape: tuple[int, int], step: float, finer: int = 4) -> Floats:
    """(n, m) share of each cell of a lattice inside rims, of which those of holes run the other way.

    It is exact along each of so many rows of a cell.
    """
    if not rims:
        return np.zeros(shape)
    return np.asarray(_drawn(np.concatenate(rims) / step, following(rims), shape[0], shape[1], finer))


def softened(share: Floats, soft: float, step: float) -> Floats:
    """A sharp picture, as one that is soft by so many mm shows it."""
    return np.asarray(gaussian_filter(share, soft / step, mode="constant"))


def following(rims: Sequence[Floats]) -> Ints:
    """(n,) the corner after each, of all rims."""
    first = np.cumsum([0, *(len(rim) for rim in rims)])
    return np.concatenate(
        [f + np.roll(np.arange(len(rim)), -1) for f, rim in zip(first[:-1], rims, strict=True)]
    )


@numba.njit(cache=True, error_model="numpy")
def _drawn(corners: Floats, after: Ints, rows: int, columns: int, finer: int) -> Floats:
    turns, share = np.zeros((rows * finer, columns + 1)), np.zeros((rows, columns))
    for k in range(len(corners)):
        x0, y0 = corners[k]
        x1, y1 = corners[after[k]]
        sign = np.sign(x1 - x0)
        first = int(np.ceil((min(x0, x1) + 0.5) * finer - 0.5))
        last = int(np.ceil((max(x0, x1) + 0.5) * finer - 0.5))
        for i in range(max(first, 0), min(last, rows * finer)):
            x = (i + 0.5) / finer - 0.5
            at = min(max(y0 + (x - x0) / (x1 - x0) * (y1 - y0) + 0.5, 0.0), float(columns))
            j = min(int(at), columns - 1)
            turns[i, j] += sign * (1.0 - at + j)
            turns[i, j + 1] += sign * (at - j)
    for i in range(rows * finer):
        inside = 0.0
        for j in range(columns):
            inside += turns[i, j]
            share[i // finer, j] += min(abs(inside), 1.0) / finer
    return share


@numba.njit(cache=True, error_model="numpy")
def within(places: Floats, reach: float, shape: tuple[int, int], step: float) -> Bools:
    """(n, m) the cells whose middles are within `reach` [mm] of one of (q, 2) places."""
    near = np.zeros(shape, dtype=np.bool_)
    for x, y in places:
        top, bottom = _range(x, reach, step, shape[0])
        left, right = _range(y, reach, step, shape[1])
        for i in range(top, bottom):
            for j in range(left, right):
                if (i * step - x) ** 2 + (j * step - y) ** 2 <= reach**2:
                    near[i, j] = True
    return near


@numba.njit(cache=True, error_model="numpy")
def slopes(
    places: Floats,
    out: Floats,
    along: Floats,
    ends: Ints,
    corners: int,
    cells: Ints,
    trust: Floats,
    soft: float,
    step: float,
) -> Floats:
    """(p, 2n) derivatives of a picture's cells by the x, then the y, of n corners.

    Of edges there are (q, 2) places, each with its way out, as long as the part of the edge that it stands for
    [mm], the share of the edge before it, and its two ends.  A picture has (n, m) `cells`, of which those that
    count are numbered from 0; the others are -1; (n, m) `trust` is what each is worth.
    """
    slope = np.zeros((cells.max() + 1, 2 * corners))
    for k in range(len(places)):
        x, y = places[k]
        one, other = ends[k]
        top, bottom = _range(x, REACH * soft, step, cells.shape[0])
        left, right = _range(y, REACH * soft, step, cells.shape[1])
        across = np.exp(-0.5 * ((np.arange(left, right) * step - y) / soft) ** 2) / (2.0 * np.pi * soft**2)
        for i in range(top, bottom):
            here = np.exp(-0.5 * ((i * step - x) / soft) ** 2)
            for j in range(left, right):
                if cells[i, j] < 0:
                    continue
                row, density = slope[cells[i, j]], here * across[j - left] * trust[i, j]
                for axis in range(2):
                    row[axis * corners + one] += density * out[k, axis] * (1.0 - along[k])
                    row[axis * corners + other] += density * out[k, axis] * along[k]
    return slope


@numba.njit(cache=True, error_model="numpy")
def normal_equations(slope: Floats, off: Floats) -> tuple[Floats, Floats]:
    """(k, k) and (k,) of the least squares of (p,) that (p, k) slopes are to explain: each row has few."""
    count = slope.shape[1]
    squares, sides = np.zeros((count, count)), np.zeros(count)
    some = np.empty(count, dtype=np.int64)
    for i in range(len(slope)):
        few = 0
        for k in range(count):
            if slope[i, k] != 0.0:
                some[few] = k
                few += 1
        for a in some[:few]:
            sides[a] += slope[i, a] * off[i]
            for b in some[:few]:
                squares[a, b] += slope[i, a] * slope[i, b]
    return squares, sides


@numba.njit(cache=True, error_model="numpy")
def _range(at: float, reach: float, step: float, count: int) -> tuple[int, int]:
    """The first, and past the last, of `count` places a step apart that lie within reach of one."""
    return max(0, int(np.ceil((at - reach) / step))), min(count, int(np.floor((at + reach) / step)) + 1)
