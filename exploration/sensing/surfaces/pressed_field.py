"""The blurred, taxel-averaged field of a clipped dome that is cut by lines, and its derivatives.

The dome is the paraboloid q, bent to the circle that a round section is: with s = g - K r the paraboloid's slope,
w = s^T K^-1 s and t = |s|^2 in the curved directions, q - (w/(1 + sqrt(1 - t)) - w/2) is the sphere or cylinder of
K exactly (R (1 - sqrt(1 - u^2/R^2)) with u = R s), and to fourth order any dome whose axes are K's.

The field is laid on cells about a blur wide that reach `MARGIN` blurs past the pad, or to the end of the skin,
which mirrors what spreads beyond it.  Each cell holds its own mean, taken as if q were linear in it and smeared
over a box of the cell's variance; exact integrals of Gaussian and box, which separate into x and y, carry it to
the taxels.  Box mean and box integral blur by h^2/12 each, so the Gaussian is made h^2/6 narrower: then the model
errs by 2 um on smooth contacts and 5 um at edges, a quarter of that with cells half as wide (our derivation).
"""

from functools import lru_cache

import numba
import numpy as np
from scipy.special import ndtr

from primitives.arrays import Floats, Ints

MARGIN = 3.0  # [blurs]
CELL = 1.05  # [blurs] no cell is wider
LEAST_BLUR = 0.25  # [taxels] a sharper skin is treated as this blurred
FLAT = 5e-4  # [1/mm] curvature below which a direction is not bent to a circle


@lru_cache(maxsize=32)
def geometry(
    rows: int, columns: int, pitch: tuple[float, float], spread: float, skin: float, fine: bool = False
) -> tuple[Floats, Floats, Floats, Floats]:
    """Cells (2, m), center and size, along x and y, and the shares that carry them to taxels.

    The shares are (3, m, columns) and (3, rows, m), times 1, t and t^2 at the cells' centers.
    """
    x, to_columns = _axis(columns, pitch[0], spread, skin, fine)
    y, to_rows = _axis(rows, pitch[1], spread, skin, fine)
    powers = np.arange(3)[:, None, None]
    columns_of = np.ascontiguousarray(x[0][:, None] ** powers * to_columns)
    rows_of = np.ascontiguousarray(y[0] ** powers * to_rows.T)
    return x, y, columns_of, rows_of


def _axis(count: int, pitch: float, spread: float, skin: float, fine: bool) -> tuple[Floats, Floats]:
    spread = max(spread, LEAST_BLUR * pitch)
    split = int(np.ceil(pitch / (CELL * spread))) * (2 if fine else 1)
    margin = min(MARGIN * spread, skin)
    ring = np.linspace(0.0, margin, int(np.ceil(margin * split / pitch - 1e-9)) + 1)[1:]
    inner = (np.arange(count * split + 1) / split - count / 2) * pitch
    edges = np.concatenate([inner[0] - ring[::-1], inner, inner[-1] + ring])
    size = np.diff(edges)
    narrowed = np.sqrt(spread**2 - size**2 / 6)
    low = ((np.arange(count) - count / 2) * pitch)[:, None]

    def integral(t: Floats) -> Floats:
        u = t / narrowed
        out: Floats = t * ndtr(u) + narrowed * np.exp(-u * u / 2) / np.sqrt(2 * np.pi)
        return out

    share = np.zeros((count, len(size)))
    for c, d in (
        (edges[:-1], edges[1:]),
        (2 * edges[0] - edges[1:], 2 * edges[0] - edges[:-1]),
        (2 * edges[-1] - edges[1:], 2 * edges[-1] - edges[:-1]),
    ):
        share += integral(low + pitch - c) - integral(low - c) - integral(low + pitch - d) + integral(low - d)
    share[share < 1e-5 * pitch] = 0.0
    shares: Floats = (share / share.sum(axis=1, keepdims=True)).T
    return np.stack([(edges[1:] + edges[:-1]) / 2, size]), shares


@numba.njit(cache=True, error_model="numpy")
def bending(kxx: float, kxy: float, kyy: float, out: Floats) -> bool:
    """Coefficients (6,) of w and t as quadratic forms of the slope (xx, xy twice, yy); false where flat."""
    mean, half = 0.5 * (kxx + kyy), np.hypot(0.5 * (kxx - kyy), kxy)
    cosine, sine = 0.5 * (kxx - kyy) / (half + 1e-12), kxy / (half + 1e-12)
    out[:] = 0.0
    for sign in (1.0, -1.0):
        k = mean + sign * half
        weight = k * k / (k * k + FLAT * FLAT)
        w = weight * k / (k * k + FLAT * FLAT)
        exx, exy, eyy = 0.5 * (1.0 + sign * cosine), 0.5 * sign * sine, 0.5 * (1.0 - sign * cosine)
        out[0] += w * exx
        out[1] += 2.0 * w * exy
        out[2] += w * eyy
        out[3] += weight * exx
        out[4] += 2.0 * weight * exy
        out[5] += weight * eyy
    return bool(abs(mean) + half > 0.0)


@numba.njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy", inline="always")
def _lowered(b: Floats, sx: float, sy: float) -> float:
    """How far the dome lies below the paraboloid where that slopes so."""
    w = b[0] * sx * sx + b[1] * sx * sy + b[2] * sy * sy
    t = min(1.0, b[3] * sx * sx + b[4] * sx * sy + b[5] * sy * sy)
    lowered: float = w * t * (0.125 + t * (0.0625 + t * (0.0390625 + t * 0.02734375)))
    return lowered


@numba.njit(cache=True, error_model="numpy")
def dome_at(p: Floats, x: float, y: float) -> tuple[float, float, float]:
    """Depth and slope of the dome that has these coefficients, before blur."""
    b = np.empty(6)
    bending(p[3], p[4], p[5], b)
    sx = p[1] - p[3] * x - p[4] * y
    sy = p[2] - p[4] * x - p[5] * y
    q = p[0] + p[1] * x + p[2] * y - 0.5 * (p[3] * x * x + p[5] * y * y) - p[4] * x * y
    ux, uy = b[3] * sx + 0.5 * b[4] * sy, 0.5 * b[4] * sx + b[5] * sy
    steeper = 0.5 * min(1.0, sx * ux + sy * uy)
    return q - _lowered(b, sx, sy), sx + steeper * ux, sy + steeper * uy


@numba.njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def fields_of(x: Floats, y: Floats, p: Floats, sides: Floats, union: bool, fields: Floats) -> None:
    """Means over cells (2 + n, ny, nx): the field, and its derivatives to d0 and to minus each line's offset.

    Every other derivative is one of these times a monomial of x and y, which `to_taxels` brings in.
    """
    n = len(sides)
    nx, ny = x.shape[1], y.shape[1]
    height, total, cover, steep = np.empty(nx), np.empty(nx), np.empty((n, nx)), np.empty((n, nx))
    b = np.empty(6)
    curved = bending(p[3], p[4], p[5], b)
    for i in range(ny):
        yy, hy = y[0, i], y[1, i]
        field, material = fields[0, i], fields[1, i]
        felt = False
        base = p[0] + p[2] * yy - 0.5 * p[5] * (yy * yy + hy * hy / 12.0)
        for j in range(nx):
            xx, hx = x[0, j], x[1, j]
            sx = p[1] - p[3] * xx - p[4] * yy
            sy = p[2] - p[4] * xx - p[5] * yy
            q = base + (p[1] - p[4] * yy) * xx - 0.5 * p[3] * (xx * xx + hx * hx / 12.0)
            if curved:
                q -= _lowered(b, sx, sy)
            inside, high = 0.0, 0.0
            reach = 0.5 * (abs(sx) * hx + abs(sy) * hy) + 1e-12
            if q >= reach:
                inside, high = 1.0, q
            elif q > -reach:
                w = 0.5 * np.sqrt(sx * sx * hx * hx + sy * sy * hy * hy) + 1e-12
                inside = min(1.0, max(0.0, (q + w) / (2.0 * w)))
                high = q if q > w else 0.5 * (q + w) * inside
            felt |= inside > 0.0
            material[j] = inside
            height[j] = high
            field[j] = high
        if n == 0:
            continue
        if not felt:
            fields[2:, i] = 0.0
            continue
        for k in range(n):
            cosine, sine, offset = np.cos(p[6 + 2 * k]), np.sin(p[6 + 2 * k]), p[7 + 2 * k]
            for j in range(nx):
                t = sides[k] * (cosine * yy - sine * x[0, j] - offset)
                half = 0.5 * np.sqrt((sine * x[1, j]) ** 2 + (cosine * hy) ** 2)
                c = (t + half) / (2.0 * half)
                steep[k, j] = 0.5 * sides[k] / half if 0.0 < c < 1.0 else 0.0
                c = min(1.0, max(0.0, c))
                cover[k, j] = 1.0 - c if union else c
        for k in range(n):
            change = fields[2 + k, i]
            change[:] = height * steep[k]
            for m in range(n):
                if m != k:
                    change *= cover[m]
        total[:] = 1.0
        for k in range(n):
            total *= cover[k]
        if union and n > 0:
            total[:] = 1.0 - total
        field *= total
        material *= total


@numba.njit(cache=True)
def to_taxels(
    fields: Floats, p: Floats, to_columns: Floats, to_rows: Floats, unknown: Ints, out: Floats
) -> None:
    """Carry `fields_of` to `out` (1 + 6 + 2 n, rows, columns): the field, and its derivatives to `p`.

    Derivatives to curvatures and lines that are held are left alone.
    """
    np.dot(to_rows[0] @ fields[0], to_columns[0], out[0])
    material, by_y = to_rows[0] @ fields[1], to_rows[1] @ fields[1]
    np.dot(material, to_columns[0], out[1])
    np.dot(material, to_columns[1], out[2])
    np.dot(by_y, to_columns[0], out[3])
    if unknown[3:6].max() >= 0:
        np.dot(-0.5 * material, to_columns[2], out[4])
        np.dot(-by_y, to_columns[1], out[5])
        np.dot(to_rows[2] @ fields[1], -0.5 * to_columns[0], out[6])
    for k in range(len(fields) - 2):
        if unknown[7 + 2 * k] >= 0:
            change, by_y = to_rows[0] @ fields[2 + k], to_rows[1] @ fields[2 + k]
            by_x = np.cos(p[6 + 2 * k]) * to_columns[1]
            by_y *= -np.sin(p[6 + 2 * k])
            np.dot(by_y, to_columns[0], out[7 + 2 * k])
            out[7 + 2 * k] -= change @ by_x
            np.dot(-change, to_columns[0], out[8 + 2 * k])
