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

WIDEST = 1.4  # [rad] of a bent edge, either way, that taxels are taken from


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
    window: tuple[float, float, float, float],
    deep: Floats,
) -> Floats:
    """(n, 4) x, y, depth and 1/sigma of the taxels from `low` to `high` along the line and not beyond `far`, nor
    `deep` in their column (`face_ends`).

    Of a bent edge only those beside `reach` of it, either way: behind the circle's center another part of the
    outline is nearer, which need not be of this circle.
    """
    angle, offset, side, bend = line
    low, high, far, reach = window
    beside = reach
    if bend != 0.0 and abs(bend) * reach > 1e-6:
        beside = np.tan(min(abs(bend) * reach, WIDEST)) / abs(bend)
    rows, columns = depth.shape
    ca, sa = np.cos(angle), np.sin(angle)
    pitch, middle = max(px, py), len(deep) // 2
    out = np.empty((rows * columns, 4))
    n = 0
    for i in range(rows):
        y = (i - (rows - 1) / 2) * py
        for j in range(columns):
            x = (j - (columns - 1) / 2) * px
            v = ca * x + sa * y
            d = side * (ca * y - sa * x - offset)
            t = inside(d, v, bend)[0]
            near = abs(v) < beside * (1.0 - bend * d)
            within = low < v < high and t < min(far, deep[int(middle + v / pitch + 0.5)])
            if near and within and sigma[i, j] < np.inf:
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
    prior: tuple[float, float, float],
    normal: Floats,
    rhs: Floats,
) -> float:
    """Fill the normal equations at p; the chi2 there (Huber's), the prior (bend, its sigma, the slopes') in it."""
    ca, sa = np.cos(p[0]), np.sin(p[0])
    chi2 = 0.0
    rows = np.empty((7, len(taxels)))  # slopes by the unknowns, and the residual, all weighed
    n = 0
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
        rows[0, n] = ((by_v * u - by_d * side * v) * steep + p[4] * u * step) * weight
        rows[1, n] = -side * by_d * steep * weight
        rows[2, n] = step * weight
        rows[3, n] = slant * weight
        rows[4, n] = v * step * weight
        rows[5, n] = by_bend * steep * weight
        rows[6, n] = r
        n += 1
    for a in range(6):
        rhs[a] = _product(rows[a], rows[6], n)
        for b in range(a + 1):
            normal[a, b] = normal[b, a] = _product(rows[a], rows[b], n)
    bend, bend_sigma, tilt = prior
    for a, expected, sigma in ((3, 0.0, tilt), (4, 0.0, tilt), (5, bend, bend_sigma)):
        surprise = (expected - p[a]) / sigma
        normal[a, a] += 1.0 / sigma**2
        rhs[a] += surprise / sigma
        chi2 += surprise * surprise
    return float(chi2)


@numba.njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy", inline="always")
def _product(a: Floats, b: Floats, count: int) -> float:
    total = 0.0
    for k in range(count):
        total += a[k] * b[k]
    return total
