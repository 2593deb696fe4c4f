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
    """Cells (2, m), center and size, along x and y, and the shares (m, taxels) that carry them to taxels."""
    x, to_columns = _axis(columns, pitch[0], spread, skin, fine)
    y, to_rows = _axis(rows, pitch[1], spread, skin, fine)
    return x, y, to_columns, to_rows


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
    shares: Floats = np.ascontiguousarray((share / share.sum(axis=1, keepdims=True)).T)
    return np.stack([(edges[1:] + edges[:-1]) / 2, size]), shares


@numba.njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def fields_of(x: Floats, y: Floats, p: Floats, sides: Floats, union: bool, fields: Floats) -> None:
    """Means over cells of the field and of its derivatives: (1 + 6 + 2 n, ny, nx)."""
    n = len(sides)
    cover = np.ones(n)
    steep = np.zeros(n)
    cosine, sine = np.empty(n), np.empty(n)
    for k in range(n):
        cosine[k], sine[k] = np.cos(p[6 + 2 * k]), np.sin(p[6 + 2 * k])
    for i in range(y.shape[1]):
        for j in range(x.shape[1]):
            xx, yy, hx, hy = x[0, j], y[0, i], x[1, j], y[1, i]
            shrink = (p[3] * hx * hx + p[5] * hy * hy) / 24.0
            q = (
                p[0]
                + p[1] * xx
                + p[2] * yy
                - 0.5 * (p[3] * xx * xx + p[5] * yy * yy)
                - p[4] * xx * yy
                - shrink
            )
            sx = p[1] - p[3] * xx - p[4] * yy
            sy = p[2] - p[4] * xx - p[5] * yy
            w = 0.5 * np.sqrt(sx * sx * hx * hx + sy * sy * hy * hy) + 1e-12
            if q <= -w:
                fields[:, i, j] = 0.0
                continue
            if q >= w:
                inside, value = 1.0, q
            else:
                inside = (q + w) / (2.0 * w)
                value = (q + w) * inside * 0.5
            total = 1.0
            for k in range(n):
                t = sides[k] * (-sine[k] * xx + cosine[k] * yy - p[7 + 2 * k])
                half = 0.5 * np.sqrt((sine[k] * hx) ** 2 + (cosine[k] * hy) ** 2)
                c = (t + half) / (2.0 * half)
                steep[k] = 0.5 / half if 0.0 < c < 1.0 else 0.0
                c = min(1.0, max(0.0, c))
                cover[k] = 1.0 - c if union else c
                total *= cover[k]
            for k in range(n):
                others = 1.0
                for m in range(n):
                    if m != k:
                        others *= cover[m]
                change = value * steep[k] * others * sides[k]
                fields[7 + 2 * k, i, j] = -change * (cosine[k] * xx + sine[k] * yy)
                fields[8 + 2 * k, i, j] = -change
            if union and n > 0:
                total = 1.0 - total
            fields[0, i, j] = value * total
            g = inside * total
            fields[1, i, j] = g
            fields[2, i, j] = g * xx
            fields[3, i, j] = g * yy
            fields[4, i, j] = -0.5 * g * xx * xx
            fields[5, i, j] = -g * xx * yy
            fields[6, i, j] = -0.5 * g * yy * yy


@numba.njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def to_taxels(fields: Floats, to_columns: Floats, to_rows: Floats, unknown: Ints, out: Floats) -> None:
    """Carry fields (1 + p, ny, nx) to `out` (1 + p, rows, columns), but for parameters that are held."""
    nx, columns = to_columns.shape
    ny, rows = to_rows.shape
    row = np.empty(columns)
    for f in range(len(fields)):
        if f > 0 and unknown[f - 1] < 0:
            continue
        out[f] = 0.0
        for i in range(ny):
            row[:] = 0.0
            filled = False
            for j in range(nx):
                value = fields[f, i, j]
                if value != 0.0:
                    filled = True
                    for c in range(columns):
                        row[c] += value * to_columns[j, c]
            if filled:
                for r in range(rows):
                    share = to_rows[i, r]
                    if share != 0.0:
                        for c in range(columns):
                            out[f, r, c] += share * row[c]
