"""The boxes over a grid of bins whose sums are greatest, compiled: a hundred thousand are looked through."""

from __future__ import annotations

import numba
import numpy as np

from primitives.arrays import Floats, Ints


@numba.njit(cache=True, error_model="numpy")
def greatest_boxes(sums: Floats, x: Ints, y: Ints, z: Ints, most: int) -> tuple[Ints, Floats]:
    """(k,) flat indices of the boxes that come to the most, in no order, and (k,) what each comes to.

    Of (a + 1, b + 1, c + 1) cumulative `sums`; each side of a box is one of (n, 2) rows of first and last bin.
    All that equal the least of the `most` greatest are among them.
    """
    totals = np.empty(len(x) * len(y) * len(z))
    best = np.full(min(most, len(totals)), -np.inf)  # a heap, its least first
    column = np.empty(sums.shape[2])
    at = 0
    for i in range(len(x)):
        low, high = sums[x[i, 0]], sums[x[i, 1]]
        for j in range(len(y)):
            first, last = y[j]
            for c in range(len(column)):
                column[c] = (high[last, c] - low[last, c]) - (high[first, c] - low[first, c])
            for k in range(len(z)):
                # rounded, that equal boxes are equal whichever way their sums were added up
                total = np.rint((column[z[k, 1]] - column[z[k, 0]]) * 1e6) / 1e6
                totals[at] = total
                at += 1
                if total > best[0]:
                    _replace_least(best, total)
    kept = np.flatnonzero(totals >= best[0])
    return kept, totals[kept]


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
