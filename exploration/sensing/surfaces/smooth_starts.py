"""Where fits of a smooth contact start: a paraboloid through the touched taxels, a plane, round domes."""

import numba
import numpy as np

from exploration.sensing.surfaces.normal_equations import invert
from primitives.arrays import Bools, Floats

BLUNTED = 1.3  # by which a paraboloid through blurred taxels is too blunt (our choice of a start)


@numba.njit(cache=True, error_model="numpy")
def start_dome(depth: Floats, precision: Floats, mask: Bools, x: Floats, y: Floats) -> Floats:
    """A paraboloid through the touched taxels by least squares; a level plane where they are too few."""
    normal, rhs, row = np.zeros((6, 6)), np.zeros(6), np.empty(6)
    count, total = 0, 0.0
    for i in range(len(y)):
        for j in range(len(x)):
            if mask[i, j] and precision[i, j] > 0.0:
                row[:] = (1.0, x[j], y[i], -0.5 * x[j] * x[j], -x[j] * y[i], -0.5 * y[i] * y[i])
                count += 1
                total += depth[i, j]
                for a in range(6):
                    rhs[a] += row[a] * depth[i, j]
                    for b in range(6):
                        normal[a, b] += row[a] * row[b]
    out = np.zeros(6)
    out[0] = total / max(1, count)
    if count > 8:
        ok, inverse = invert(normal)
        if ok:
            out = inverse @ rhs
            out[3:] *= BLUNTED
    return out


@numba.njit(cache=True, error_model="numpy")
def mean_depth(depth: Floats, precision: Floats, mask: Bools) -> float:
    """Of the touched taxels that can be read."""
    count, total = 0, 0.0
    for i in range(depth.shape[0]):
        for j in range(depth.shape[1]):
            if mask[i, j] and precision[i, j] > 0.0:
                count += 1
                total += depth[i, j]
    return total / max(1, count)


@numba.njit(cache=True, error_model="numpy")
def round_start(
    depth: Floats, precision: Floats, mask: Bools, x: Floats, y: Floats, scale: float, height: float
) -> Floats:
    """A round dome over the mask, so much higher than what is felt."""
    top = cx = cy = 0.0
    count = 0
    for i in range(len(y)):
        for j in range(len(x)):
            if mask[i, j] and precision[i, j] > 0.0:
                top = max(top, depth[i, j])
                cx += x[j]
                cy += y[i]
                count += 1
    cx, cy = cx / max(1, count), cy / max(1, count)
    top = height * top + 1e-6
    px = x[1] - x[0] if len(x) > 1 else 1.0
    py = y[1] - y[0] if len(y) > 1 else 1.0
    k = 2.0 * top / max(count * px * py / np.pi, scale)
    return np.array([top - 0.5 * k * (cx * cx + cy * cy), k * cx, k * cy, k, 0.0, k])
