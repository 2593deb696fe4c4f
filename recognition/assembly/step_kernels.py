"""What single steps of the search are chosen by, compiled: the boxes and the prisms whose cells are worth most."""

from __future__ import annotations

import numba
import numpy as np

from primitives.arrays import Bools, Floats, Ints


@numba.njit(cache=True, error_model="numpy")
def cumulative(cells: Ints, worth: Floats, counts: tuple[int, int, int]) -> Floats:
    """(a + 1, b + 1, c + 1) sums over all bins before, of (n,) `worth` in the bins `cells` (n, 3) of `counts`."""
    sums = np.zeros((counts[0] + 1, counts[1] + 1, counts[2] + 1))
    for n in range(len(worth)):
        sums[cells[n, 0] + 1, cells[n, 1] + 1, cells[n, 2] + 1] += worth[n]
    for i in range(1, sums.shape[0]):
        for j in range(1, sums.shape[1]):
            row = 0.0
            for k in range(1, sums.shape[2]):
                row += sums[i, j, k]
                sums[i, j, k] = row + sums[i - 1, j, k] + sums[i, j - 1, k] - sums[i - 1, j - 1, k]
    return sums


@numba.njit(cache=True, error_model="numpy")
def lot_sums(lots: Ints, worth: Floats, count: int) -> Floats:
    """(count,) what the cells of each lot are worth together, of (c, b) lots of cells and their (c,) `worth`."""
    sums = np.zeros(count)
    for cell in range(len(worth)):
        if worth[cell] != 0.0:  # most are worth nothing
            for body in range(lots.shape[1]):
                sums[lots[cell, body]] += worth[cell]
    return sums


@numba.njit(cache=True, error_model="numpy")
def greatest_boxes(sums: Floats, x: Ints, y: Ints, z: Ints, most: int) -> tuple[Ints, Floats]:
    """(k,) flat indices of the boxes that come to the most, in no order, and (k,) what each comes to.

    Of (a + 1, b + 1, c + 1) cumulative `sums`; each side of a box is one of (n, 2) rows of first and last bin.
    All that equal the least of the `most` greatest are among them.  Of most pairs of the first two sides not even
    the best third comes near those.
    """
    best = np.full(min(most, len(x) * len(y) * len(z)), -np.inf)  # a heap, its least first
    at, totals, count = np.empty(64, np.int64), np.empty(64), 0
    column = np.empty(sums.shape[2])
    for i in range(len(x)):
        low, high = sums[x[i, 0]], sums[x[i, 1]]
        for j in range(len(y)):
            first, last = y[j]
            least, greatest = np.inf, -np.inf
            for c in range(len(column)):
                column[c] = (high[last, c] - low[last, c]) - (high[first, c] - low[first, c])
                greatest = max(greatest, column[c] - least)
                least = min(least, column[c])
            if _rounded(greatest) < best[0]:
                continue
            for k in range(len(z)):
                total = _rounded(column[z[k, 1]] - column[z[k, 0]])
                if total < best[0]:
                    continue
                if total > best[0]:
                    _replace_least(best, total)
                if count == len(at):
                    at, totals = np.concatenate((at, at)), np.concatenate((totals, totals))
                at[count], totals[count] = (i * len(y) + j) * len(z) + k, total
                count += 1
    kept = np.flatnonzero(totals[:count] >= best[0])
    return at[kept], totals[kept]


@numba.njit(cache=True, error_model="numpy", inline="always")
def _rounded(total: float) -> float:
    """So that equal boxes are equal whichever way their sums were added up."""
    return float(np.rint(total * 1e6) / 1e6)


@numba.njit(cache=True, error_model="numpy")
def kept_sides(beyond: Bools, worth: Floats) -> Bools:
    """(p,) which sides stand after those were dropped, the best first, that let in what is worth most.

    `beyond` (c, p) are the sides that each of (c,) cells of some `worth` lies on the other side of.
    """
    cells, sides = beyond.shape
    kept, gains, left = np.ones(sides, np.bool_), np.zeros(sides), sides
    missing = np.empty(cells, np.int64)
    for c in range(cells):
        missing[c] = beyond[c].sum()
        if missing[c] == 1:
            gains[np.argmax(beyond[c])] += worth[c]
    while left > 1:
        best = -1
        for k in range(sides):
            if kept[k] and (best < 0 or _rounded(gains[k]) > _rounded(gains[best])):
                best = k
        if _rounded(gains[best]) < 0.0:
            break
        kept[best] = False
        left -= 1
        for c in range(cells):
            if beyond[c, best]:
                missing[c] -= 1
                if missing[c] == 1:
                    gains[np.argmax(beyond[c] & kept)] += worth[c]
    return kept


@numba.njit(cache=True, error_model="numpy", inline="always")
def _replace_least(heap: Floats, value: float) -> None:
    """Put a value in the place of a heap's least."""
    at = 0
    while True:
        child = 2 * at + 1
        if child >= len(heap):
            break
        if child + 1 < len(heap) and heap[child + 1] < heap[child]:
            child += 1
        if value <= heap[child]:
            break
        heap[at] = heap[child]
        at = child
    heap[at] = value
