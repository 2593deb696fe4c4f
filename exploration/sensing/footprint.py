"""The forward model of a contact: a paraboloid, cut by straight edges, pressed into a blurring skin.

    depth = taxel mean of blur * [ max(0, q) C ],   q(x, y) = d0 + gx x + gy y - (kxx x^2 + 2 kxy x y + kyy y^2)/2,

with C the indicator of the material: the product of the half-planes of its edges (a corner, a thin wall), or the
complement of the product of their complements (`union`: an inside corner, a slot).  The field is laid on cells
about a blur wide that reach `MARGIN` blurs past the pad.  Each cell holds its own mean, taken as if q were linear
in it and smeared over a box of the cell's variance; exact integrals of Gaussian and box, which separate
into x and y, carry it to the taxels.  Box mean and box integral blur by h^2/12 each, so the Gaussian is made
h^2/6 narrower: then the model errs by 2 um on smooth contacts, 5 um at edges (our derivation).

Gauss-Newton with Levenberg's damping on all unknowns at once, for no closed form of a clipped paraboloid exists,
with a weak prior on curvature for contacts smaller than the blur.
"""

from dataclasses import dataclass
from functools import lru_cache

import numba
import numpy as np
from scipy.special import ndtr

from exploration.sensing.frame import TactileImage
from exploration.sensing.normal_equations import invert
from primitives.arrays import Floats, Ints, frozen

MARGIN = 3.0  # [blurs]
CELL = 1.05  # [blurs] no cell is wider
LEAST_BLUR = 0.25  # [taxels] a sharper skin is treated as this blurred
HUBER = 3.0  # [sigma]
CURVATURE = 0.3  # [1/mm] standard deviation of the prior: sharper than most that a pad can read
STEPS = 30
GAINED = 0.02  # [chi2] a step that gains less is the last
PLANE, ROUND, PARABOLOID = "plane", "round", "paraboloid"


@dataclass(frozen=True)
class Footprint:
    """The best parameters of the forward model for one frame."""

    parameters: Floats  # (6 + 2 n,) d0 [mm], gx, gy, kxx, kxy, kyy [1/mm], then (angle, offset) per line
    covariance: Floats  # same order; zero rows for what was held
    chi2: float  # Huber's
    dof: int
    converged: bool
    residual: Floats  # (rows, columns) [sigma]; 0 where dead


def fit_footprint(
    image: TactileImage,
    start: Floats,
    sides: Floats,
    union: bool = False,
    shape: str = PARABOLOID,
    free_lines: bool = True,
    steps: int = STEPS,
) -> Footprint:
    """Fit from `start` (6 + 2 n,); `sides` (n,) is +1 where the material is on a line's positive side.

    `shape` is PLANE (curvature held), ROUND (kxx = kyy, kxy = 0) or PARABOLOID.
    """
    geometry = _geometry(image.array.rows, image.array.columns, image.array.pitch, image.spread)
    unknown = _unknowns(shape, len(start), free_lines)
    p, covariance, chi2, count, converged, residual = _fit(
        image.depth,
        image.sigma,
        *geometry,
        np.array(start, dtype=float),
        np.asarray(sides, dtype=float),
        unknown,
        union,
        steps,
    )
    return Footprint(p, covariance, chi2, count - int(unknown.max()) - 1, converged, residual)


@lru_cache(maxsize=64)
def _unknowns(shape: str, count: int, free_lines: bool) -> Ints:
    """Which unknown each parameter is; -1 where it is held, the same twice where two are one."""
    first = {PLANE: [0, 1, 2, -1, -1, -1], ROUND: [0, 1, 2, 3, -1, 3], PARABOLOID: [0, 1, 2, 3, 4, 5]}[shape]
    lines = np.arange(count - 6) + max(first) + 1 if free_lines else np.full(count - 6, -1)
    return frozen(np.concatenate([np.array(first), lines]), np.int64)


@lru_cache(maxsize=32)
def _geometry(
    rows: int, columns: int, pitch: tuple[float, float], spread: float
) -> tuple[Floats, Floats, Floats, Floats]:
    x, to_columns = _axis(columns, pitch[0], spread)
    y, to_rows = _axis(rows, pitch[1], spread)
    return x, y, to_columns, to_rows


def _axis(count: int, pitch: float, spread: float) -> tuple[Floats, Floats]:
    """Cell centers (m,) and the share of each cell in each taxel (count, m)."""
    spread = max(spread, LEAST_BLUR * pitch)
    split = int(np.ceil(pitch / (CELL * spread)))
    size = pitch / split
    margin = int(np.ceil(MARGIN * spread / size))
    m = count * split + 2 * margin
    x = (np.arange(m) - (m - 1) / 2) * size
    centers = (np.arange(count) - (count - 1) / 2) * pitch
    narrowed = float(np.sqrt(spread**2 - size**2 / 6))

    def integral(t: Floats) -> Floats:
        u = t / narrowed
        out: Floats = t * ndtr(u) + narrowed * np.exp(-u * u / 2) / np.sqrt(2 * np.pi)
        return out

    a, b = centers[:, None] - pitch / 2, centers[:, None] + pitch / 2
    c, d = x[None, :] - size / 2, x[None, :] + size / 2
    share = (integral(b - c) - integral(a - c) - integral(b - d) + integral(a - d)) / pitch
    share[share < 1e-5] = 0.0
    normalized: Floats = np.ascontiguousarray(share / share.sum(axis=1, keepdims=True))
    return np.asarray(x, dtype=np.float64), normalized


@numba.njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def _fields(x: Floats, y: Floats, p: Floats, sides: Floats, union: bool, fields: Floats) -> None:
    """Means over cells of the field and of its derivatives: (1 + 6 + 2 n, ny, nx)."""
    hx, hy = x[1] - x[0], y[1] - y[0]
    n = len(sides)
    cover = np.ones(n)
    steep = np.zeros(n)
    cosine, sine, half = np.empty(n), np.empty(n), np.empty(n)
    for k in range(n):
        cosine[k], sine[k] = np.cos(p[6 + 2 * k]), np.sin(p[6 + 2 * k])
        half[k] = 0.5 * np.sqrt((sine[k] * hx) ** 2 + (cosine[k] * hy) ** 2)
    shrink = (p[3] * hx * hx + p[5] * hy * hy) / 24.0
    for i in range(len(y)):
        for j in range(len(x)):
            xx, yy = x[j], y[i]
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
                c = (t + half[k]) / (2.0 * half[k])
                steep[k] = 0.5 / half[k] if 0.0 < c < 1.0 else 0.0
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
def _to_taxels(fields: Floats, to_columns: Floats, to_rows: Floats, unknown: Ints, out: Floats) -> None:
    columns, nx = to_columns.shape
    rows, ny = to_rows.shape
    first, last = np.empty(columns, dtype=np.int64), np.empty(columns, dtype=np.int64)
    for c in range(columns):
        a, b = 0, nx
        while to_columns[c, a] == 0.0:
            a += 1
        while to_columns[c, b - 1] == 0.0:
            b -= 1
        first[c], last[c] = a, b
    row = np.empty(columns)
    for f in range(len(fields)):
        if f > 0 and unknown[f - 1] < 0:
            continue
        out[f] = 0.0
        for i in range(ny):
            filled = False
            for j in range(nx):
                if fields[f, i, j] != 0.0:
                    filled = True
                    break
            if not filled:
                continue
            for c in range(columns):
                s = 0.0
                for j in range(first[c], last[c]):
                    s += to_columns[c, j] * fields[f, i, j]
                row[c] = s
            for r in range(rows):
                share = to_rows[r, i]
                if share != 0.0:
                    for c in range(columns):
                        out[f, r, c] += share * row[c]


@numba.njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def _normal_equations(
    depth: Floats,
    sigma: Floats,
    p: Floats,
    model: Floats,
    unknown: Ints,
    normal: Floats,
    rhs: Floats,
    residual: Floats,
) -> tuple[float, int]:
    rows, columns = depth.shape
    m = len(rhs)
    normal[:] = 0.0
    rhs[:] = 0.0
    chi2 = 0.0
    count = 0
    jacobian = np.empty(m)
    for i in range(rows):
        for j in range(columns):
            residual[i, j] = 0.0
            if sigma[i, j] == np.inf:
                continue
            r = (depth[i, j] - model[0, i, j]) / sigma[i, j]
            residual[i, j] = r
            count += 1
            size = abs(r)
            weight = 1.0
            if size > HUBER:
                chi2 += HUBER * (2.0 * size - HUBER)
                weight = HUBER / size
            else:
                chi2 += r * r
            jacobian[:] = 0.0
            for k in range(len(unknown)):
                if unknown[k] >= 0:
                    jacobian[unknown[k]] += model[1 + k, i, j] / sigma[i, j]
            for a in range(m):
                rhs[a] += jacobian[a] * r * weight
                for b in range(a + 1):
                    normal[a, b] += jacobian[a] * jacobian[b] * weight
    for k in range(3, 6):
        a = unknown[k]
        if a >= 0:
            chi2 += (p[k] / CURVATURE) ** 2
            rhs[a] -= p[k] / CURVATURE**2
            normal[a, a] += 1.0 / CURVATURE**2
    for a in range(m):
        for b in range(a):
            normal[b, a] = normal[a, b]
    return chi2, count


@numba.njit(cache=True, error_model="numpy")
def _fit(
    depth: Floats,
    sigma: Floats,
    x: Floats,
    y: Floats,
    to_columns: Floats,
    to_rows: Floats,
    start: Floats,
    sides: Floats,
    unknown: Ints,
    union: bool,
    steps: int,
) -> tuple[Floats, Floats, float, int, bool, Floats]:
    m = unknown.max() + 1
    total = len(start)
    fields = np.zeros((1 + total, len(y), len(x)))
    model = np.zeros((1 + total, depth.shape[0], depth.shape[1]))
    normal, rhs, residual = np.zeros((m, m)), np.zeros(m), np.zeros(depth.shape)
    trial_normal, trial_rhs, trial_residual = np.zeros((m, m)), np.zeros(m), np.zeros(depth.shape)
    p = start.copy()
    _fields(x, y, p, sides, union, fields)
    _to_taxels(fields, to_columns, to_rows, unknown, model)
    chi2, count = _normal_equations(depth, sigma, p, model, unknown, normal, rhs, residual)
    damping = 1e-3
    converged = False
    for _ in range(steps):
        damped = normal.copy()
        for a in range(m):
            damped[a, a] *= 1.0 + damping
        ok, inverse = invert(damped)
        if not ok:
            damping = max(1e-3, damping * 10.0)
            if damping > 1e6:
                break
            continue
        step = inverse @ rhs
        trial = p.copy()
        for k in range(total):
            if unknown[k] >= 0:
                trial[k] += step[unknown[k]]
        _fields(x, y, trial, sides, union, fields)
        _to_taxels(fields, to_columns, to_rows, unknown, model)
        new, count = _normal_equations(
            depth, sigma, trial, model, unknown, trial_normal, trial_rhs, trial_residual
        )
        if new < chi2:
            gained = chi2 - new
            p = trial
            chi2 = new
            normal[:] = trial_normal
            rhs[:] = trial_rhs
            residual[:] = trial_residual
            damping = damping * 0.1 if damping > 1e-6 else 0.0
            if gained < GAINED:
                converged = True
                break
        else:
            if np.dot(step, rhs) < GAINED:
                converged = True
                break
            damping = max(1e-3, damping * 10.0)
            if damping > 1e8:
                break
    covariance = np.zeros((total, total))
    ok, inverse = invert(normal)
    if ok:
        for k in range(total):
            for j in range(total):
                if unknown[k] >= 0 and unknown[j] >= 0:
                    covariance[k, j] = inverse[unknown[k], unknown[j]]
    return p, covariance, chi2, count, converged and ok, residual
