"""The blurred, taxel-averaged field of a clipped paraboloid that is cut by lines, and its derivatives.

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


@numba.njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def fields_of(x: Floats, y: Floats, p: Floats, sides: Floats, union: bool, fields: Floats) -> None:
    """Means over cells (2 + n, ny, nx): the field, and its derivatives to d0 and to minus each line's offset.

    Every other derivative is one of these times a monomial of x and y, which `to_taxels` brings in.
    """
    n = len(sides)
    nx, ny = x.shape[1], y.shape[1]
    height, total, cover, steep = np.empty(nx), np.empty(nx), np.empty((n, nx)), np.empty((n, nx))
    for i in range(ny):
        yy, hy = y[0, i], y[1, i]
        field, material = fields[0, i], fields[1, i]
        for j in range(nx):
            xx, hx = x[0, j], x[1, j]
            sx = p[1] - p[3] * xx - p[4] * yy
            sy = p[2] - p[4] * xx - p[5] * yy
            curved = p[3] * (xx * xx + hx * hx / 12.0) + p[5] * (yy * yy + hy * hy / 12.0)
            q = p[0] + p[1] * xx + p[2] * yy - 0.5 * curved - p[4] * xx * yy
            w = 0.5 * np.sqrt(sx * sx * hx * hx + sy * sy * hy * hy) + 1e-12
            inside = min(1.0, max(0.0, (q + w) / (2.0 * w)))
            material[j] = inside
            height[j] = q if q > w else 0.5 * (q + w) * inside
            field[j] = height[j]
        if not height.any():
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
