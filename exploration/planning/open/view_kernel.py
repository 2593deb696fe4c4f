"""What straight approaches along one direction would see: one for each crossing of two rows of lines."""

import numba
import numpy as np

from primitives.arrays import Bools, Floats, Ints


@numba.njit(cache=True, error_model="numpy")
def looked_into(
    unseen: Floats, felt: Floats, shown: Bools, x: Floats, y: Floats, half: Floats, first: float
) -> tuple[Ints, Floats, Bools]:
    """Of pads with (2,) `half` sizes [mm] that come along +z, their middle at each (x, y); all (len(x), len(y)).

    How many of (n, 3) unseen cells each passes before the first of (m, 3) felt places stops it; where that is
    [mm]; and whether what comes first there, up to `first` mm behind it, was never `shown` from this side.
    """
    count = np.zeros((len(x), len(y)), np.int64)
    stop = np.full(count.shape, np.inf)
    for n in range(len(felt)):
        for i in range(len(x)):
            if abs(felt[n, 0] - x[i]) < half[0]:
                for j in range(len(y)):
                    if abs(felt[n, 1] - y[j]) < half[1]:
                        stop[i, j] = min(stop[i, j], felt[n, 2])
    ends, known = np.zeros(count.shape, np.bool_), np.zeros(count.shape, np.bool_)
    for n in range(len(felt)):
        for i in range(len(x)):
            if abs(felt[n, 0] - x[i]) < half[0]:
                for j in range(len(y)):
                    if abs(felt[n, 1] - y[j]) < half[1] and felt[n, 2] < stop[i, j] + first:
                        ends[i, j] = True
                        known[i, j] |= shown[n]
    for n in range(len(unseen)):
        for i in range(len(x)):
            if abs(unseen[n, 0] - x[i]) < half[0]:
                for j in range(len(y)):
                    if abs(unseen[n, 1] - y[j]) < half[1] and unseen[n, 2] < stop[i, j]:
                        count[i, j] += 1
    return count, stop, ends & ~known
