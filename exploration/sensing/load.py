"""What presses on an array as a whole, in one pass over its taxels; dead ones feel nothing.

With f = stiffness * depth * taxel area the force on a taxel at (x, y), the force is sum f, its moments about the
pad's center are -sum y f and sum x f, and its standard deviation is that of the sum.
"""

from typing import NamedTuple

import numba
import numpy as np

from exploration.sensing.frame import TactileImage
from primitives.arrays import Floats


class Load(NamedTuple):
    """The pressure on an array, summed."""

    force: float  # [N] along the sensor's -z
    about_x: float  # [N mm]
    about_y: float  # [N mm]
    sigma: float  # [N] of the force
    peak: float  # [mm] greatest mean depth over 2 x 2 taxels, so that no noisy one is it


def load_of(image: TactileImage) -> Load:
    """The load of one frame."""
    px, py = image.array.pitch
    total, by_x, by_y, square, peak = _summed(image.depth, image.sigma)
    each = image.stiffness * px * py
    return Load(each * total, -each * py * by_y, each * px * by_x, each * float(np.sqrt(square)), peak)


def stands_out(image: TactileImage, sigmas: float) -> bool:
    """Whether 3 x 3 taxels together lie above `sigmas` of their own standard deviation, as the median taxel's."""
    return bool(_stands_out(image.depth, image.sigma, sigmas))


@numba.njit(cache=True, error_model="numpy")
def _summed(depth: Floats, sigma: Floats) -> tuple[float, float, float, float, float]:
    """Sums of depth, of it times column and row from the middle, and of variance; the peak."""
    rows, columns = depth.shape
    total = by_x = by_y = square = 0.0
    peak = 0.0
    whole = rows < 2 or columns < 2
    for i in range(rows):
        along = 0.0
        for j in range(columns):
            if sigma[i, j] == np.inf:
                continue
            d = depth[i, j]
            along += d
            by_x += d * (j - 0.5 * (columns - 1))
            square += sigma[i, j] ** 2
            if whole:
                peak = max(peak, d)
        total += along
        by_y += along * (i - 0.5 * (rows - 1))
    if not whole:
        peak = -np.inf
        for i in range(rows - 1):
            for j in range(columns - 1):
                mean = 0.0
                for a in range(i, i + 2):
                    for b in range(j, j + 2):
                        if sigma[a, b] != np.inf:
                            mean += 0.25 * depth[a, b]
                peak = max(peak, mean)
    return total, by_x, by_y, square, peak


@numba.njit(cache=True, error_model="numpy")
def _stands_out(depth: Floats, sigma: Floats, sigmas: float) -> bool:
    rows, columns = depth.shape
    noise = np.empty(rows * columns)
    n = 0
    most = -np.inf
    for i in range(rows):
        for j in range(columns):
            if sigma[i, j] != np.inf:
                noise[n] = sigma[i, j]
                n += 1
            total = 0.0
            for a in range(max(0, i - 1), min(rows, i + 2)):
                for b in range(max(0, j - 1), min(columns, j + 2)):
                    if sigma[a, b] != np.inf:
                        total += depth[a, b]
            most = max(most, total)
    if n == 0 or most <= 3.0 * sigmas * noise[:n].min():
        return False
    return bool(most > 3.0 * sigmas * np.median(noise[:n]))
