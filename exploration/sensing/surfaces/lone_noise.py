"""Whether what a fit leaves of a frame is noise alone."""

import numba
import numpy as np

from primitives.arrays import Floats


@numba.njit(cache=True, error_model="numpy")
def unexplained(residual: Floats, sigma: Floats) -> tuple[float, float]:
    """How far residuals [sigma] of a frame are from lone noise: their greatest 3 x 3 sum, and neighbors' likeness.

    Both in their own standard deviations; the greatest of some 100 blocks is about 2.6 where all is noise.
    """
    rows, columns = residual.shape
    alike, pairs = 0.0, 0
    for i in range(rows):
        for j in range(columns):
            if i + 1 < rows:
                alike += residual[i, j] * residual[i + 1, j]
                pairs += 1
            if j + 1 < columns:
                alike += residual[i, j] * residual[i, j + 1]
                pairs += 1
    return greatest_block(residual, sigma), alike / np.sqrt(max(1, pairs))


@numba.njit(cache=True, error_model="numpy")
def greatest_block(residual: Floats, sigma: Floats) -> float:
    """The largest sum of residuals [sigma] over 3 x 3 taxels, in its standard deviations."""
    rows, columns = residual.shape
    greatest = 0.0
    for i in range(rows):
        for j in range(columns):
            total, count = 0.0, 0
            for a in range(max(0, i - 1), min(rows, i + 2)):
                for b in range(max(0, j - 1), min(columns, j + 2)):
                    if sigma[a, b] != np.inf:
                        total += residual[a, b]
                        count += 1
            greatest = max(greatest, abs(total) / np.sqrt(max(1, count)))
    return float(greatest)
