"""Where a frame's single edge may be: none that a plane explains, else the moments of the gradient.

Each taxel's gradient g (central differences, averaged over three taxels across) counts by how far |g|^2 rises
above `FLOOR` of the steepest.  The edge's normal is the mean direction, its offset that of the center, and its
plateau the mean depth more than a width inside: one window of an adaptive Hough transform, round one peak.
"""

import numba
import numpy as np

from primitives.arrays import Floats

FLOOR = 0.25  # of the steepest squared gradient
LONELY = 6.0  # [sigma] beyond all its neighbors, from which a taxel is taken for dead


@numba.njit(cache=True, error_model="numpy")
def quiet_variance(z: Floats, sigma: Floats, gain: float, variance: Floats) -> float:
    """Fill the variance (n,) that noise alone gives each taxel, without its gain's; its root mean square."""
    total, count = 0.0, 0
    flat = sigma.copy().reshape(len(z))
    for i in range(len(z)):
        variance[i] = flat[i] * flat[i]
        if flat[i] == np.inf:
            z[i] = 0.0
            continue
        if gain > 0.0:
            variance[i] = max(1e-4 * variance[i], variance[i] - (gain * max(0.0, z[i])) ** 2)
        total += variance[i]
        count += 1
    return float(np.sqrt(total / max(1, count)))


@numba.njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def plane_chi2(
    z: Floats, variance: Floats, gain: float, columns: int, px: float, py: float
) -> tuple[float, int]:
    """chi2 of the best plane, and its degrees of freedom."""
    n, nx, ny, nz, xx, xy, yy, xz, yz, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    count = 0
    for i in range(len(z) // columns):
        y = i * py
        for j in range(columns):
            k = i * columns + j
            if variance[k] == np.inf:
                continue
            x = j * px
            w = 1.0 / (variance[k] + (gain * max(0.0, z[k])) ** 2)
            d = z[k]
            n += w
            nx += w * x
            ny += w * y
            nz += w * d
            xx += w * x * x
            xy += w * x * y
            yy += w * y * y
            xz += w * x * d
            yz += w * y * d
            zz += w * d * d
            count += 1
    if count < 4:
        return 0.0, 0
    xx -= nx * nx / n
    xy -= nx * ny / n
    yy -= ny * ny / n
    xz -= nx * nz / n
    yz -= ny * nz / n
    zz -= nz * nz / n
    determinant = xx * yy - xy * xy
    if determinant <= 1e-9 * xx * yy:
        return zz, count - 1
    return zz - (yy * xz * xz - 2.0 * xy * xz * yz + xx * yz * yz) / determinant, count - 3


@numba.njit(cache=True, error_model="numpy")
def without_outliers(z: Floats, variance: Floats, rows: int, columns: int) -> Floats:
    """Each taxel between the least and the greatest of its neighbors beside, above and below.

    An edge changes nothing by this; a taxel that died without telling is set right, and left out: its variance
    becomes infinite.
    """
    out = z.copy()
    for i in range(rows):
        for j in range(columns):
            k = i * columns + j
            low, high, count = np.inf, -np.inf, 0
            if i > 0:
                low, high, count = min(low, z[k - columns]), max(high, z[k - columns]), count + 1
            if i < rows - 1:
                low, high, count = min(low, z[k + columns]), max(high, z[k + columns]), count + 1
            if j > 0:
                low, high, count = min(low, z[k - 1]), max(high, z[k - 1]), count + 1
            if j < columns - 1:
                low, high, count = min(low, z[k + 1]), max(high, z[k + 1]), count + 1
            out[k] = min(high, max(low, z[k]))
            off = z[k] - out[k]
            if count > 2 and off * off > LONELY * LONELY * variance[k]:
                variance[k] = np.inf
    return out


@numba.njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def first_edge(
    z: Floats, variance: Floats, rows: int, columns: int, px: float, py: float, blur: Floats, p: Floats
) -> float:
    """Fill angle, offset and plateau; the material's side, or 0 where the gradients cancel."""
    gx, gy, square = np.empty(rows * columns), np.empty(rows * columns), np.empty(rows * columns)
    steepest = 0.0
    for i in range(rows):
        low, high = max(0, i - 1), min(rows - 1, i + 1)
        for j in range(columns):
            left, right = max(0, j - 1), min(columns - 1, j + 1)
            k = i * columns + j
            sx, sy = 0.0, 0.0
            for a in range(low, high + 1):
                sx += z[a * columns + right] - z[a * columns + left]
            for b in range(left, right + 1):
                sy += z[high * columns + b] - z[low * columns + b]
            sx /= (right - left) * px * (high - low + 1)
            sy /= (high - low) * py * (right - left + 1)
            gx[k], gy[k] = sx, sy
            square[k] = sx * sx + sy * sy
            steepest = max(steepest, square[k])
    total, cx, cy, mx, my = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(rows):
        for j in range(columns):
            k = i * columns + j
            w = square[k] - FLOOR * steepest
            if w > 0.0 and variance[k] != np.inf:
                total += w
                cx += w * j
                cy += w * i
                mx += w * gx[k]
                my += w * gy[k]
    size = np.hypot(mx, my)
    if not size > 0.3 * total * np.sqrt(steepest) or total == 0.0:
        return 0.0
    mx, my = mx / size, my / size
    p[0] = np.arctan2(-mx, my)
    p[1] = mx * (cx / total - (columns - 1) / 2) * px + my * (cy / total - (rows - 1) / 2) * py
    width = np.sqrt(blur[0] * mx * mx + blur[1] * my * my)
    inside, ins, deepest = 0.0, 0, 0.0
    for i in range(rows):
        for j in range(columns):
            k = i * columns + j
            t = mx * (j - (columns - 1) / 2) * px + my * (i - (rows - 1) / 2) * py - p[1]
            deepest = max(deepest, z[k])
            if t > width:
                inside += z[k]
                ins += 1
    p[2] = inside / ins if ins else deepest
    return 1.0
