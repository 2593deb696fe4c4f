"""An edge that is bent to a circle, pressed into the skin: the model that an expected edge is fitted by.

The model is `line_fit`'s, bent to a curvature kappa (of the edge, in the pad's plane, positive where it bends
toward the material): with a the angle, rho the offset, s the material's side, (u, v) coordinates across and along
the line, and d = s (u - rho), the distance from a circle of curvature kappa is

    t = 2 (d - kappa (d^2 + v^2) / 2) / (1 + D),   D = sqrt((1 - kappa d)^2 + kappa^2 v^2),
    depth = (A + c v) edge(t/w) + b w ramp(t/w).
"""

import numba
import numpy as np

from exploration.sensing.response import look_up
from exploration.sensing.surfaces.normal_equations import HUBER
from primitives.arrays import Floats


@numba.njit(cache=True, inline="always")
def inside(d: float, v: float, bend: float) -> tuple[float, float, float, float]:
    """Distance t inside a bent edge, and its derivatives by d, v and (to first order) the bend."""
    root = np.sqrt((1.0 - bend * d) ** 2 + (bend * v) ** 2)
    square = d * d + v * v
    share = 1.0 / (1.0 + root)
    return (2.0 * d - bend * square) * share, (1.0 - bend * d) / root, -bend * v / root, -square * share


@numba.njit(cache=True, error_model="numpy")
def chosen(
    depth: Floats,
    sigma: Floats,
    px: float,
    py: float,
    line: tuple[float, float, float, float],
    window: tuple[float, float, float],
) -> Floats:
    """(n, 4) x, y, depth and 1/sigma of the taxels from `low` to `high` along the line and not beyond `far`."""
    angle, offset, side, bend = line
    low, high, far = window
    rows, columns = depth.shape
    ca, sa = np.cos(angle), np.sin(angle)
    out = np.empty((rows * columns, 4))
    n = 0
    for i in range(rows):
        y = (i - (rows - 1) / 2) * py
        for j in range(columns):
            x = (j - (columns - 1) / 2) * px
            v = ca * x + sa * y
            t = inside(side * (ca * y - sa * x - offset), v, bend)[0]
            if sigma[i, j] < np.inf and low < v < high and t < far:
                out[n, 0], out[n, 1] = x, y
                out[n, 2], out[n, 3] = depth[i, j], 1.0 / sigma[i, j]
                n += 1
    return out[:n]


@numba.njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def weighed(
    taxels: Floats,
    table: Floats,
    width: float,
    p: Floats,
    side: float,
    prior: tuple[float, float],
    normal: Floats,
    rhs: Floats,
) -> float:
    """Fill the normal equations at p; the chi2 there (Huber's), the prior (bend, sigma) among it."""
    normal[:] = 0.0
    rhs[:] = 0.0
    ca, sa = np.cos(p[0]), np.sin(p[0])
    chi2 = 0.0
    j6 = np.empty(6)
    for k in range(len(taxels)):
        x, y, weight = taxels[k, 0], taxels[k, 1], taxels[k, 3]
        u, v = ca * y - sa * x, ca * x + sa * y
        t, by_d, by_v, by_bend = inside(side * (u - p[1]), v, p[5])
        change, step, slant = look_up(table, t / width, 0)
        change, slant = change / width, slant * width
        r = (taxels[k, 2] - (p[2] + p[4] * v) * step - p[3] * slant) * weight
        size = abs(r)
        if size > HUBER:
            chi2 += HUBER * (2.0 * size - HUBER)
            share = np.sqrt(HUBER / size)
            weight *= share
            r *= share
        else:
            chi2 += r * r
        if step == 0.0:
            continue
        steep = (p[2] + p[4] * v) * change + p[3] * step
        j6[0] = ((by_v * u - by_d * side * v) * steep + p[4] * u * step) * weight
        j6[1] = -side * by_d * steep * weight
        j6[2] = step * weight
        j6[3] = slant * weight
        j6[4] = v * step * weight
        j6[5] = by_bend * steep * weight
        for a in range(6):
            rhs[a] += j6[a] * r
            for b in range(a + 1):
                normal[a, b] += j6[a] * j6[b]
    for a in range(6):
        for b in range(a):
            normal[b, a] = normal[a, b]
    surprise = (prior[0] - p[5]) / prior[1]
    normal[5, 5] += 1.0 / prior[1] ** 2
    rhs[5] += surprise / prior[1]
    return float(chi2 + surprise * surprise)
