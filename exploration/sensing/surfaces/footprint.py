"""The forward model of a contact: a paraboloid, cut by straight edges, pressed into a blurring skin.

    depth = taxel mean of blur * [ max(0, q) C ],   q(x, y) = d0 + gx x + gy y - (kxx x^2 + 2 kxy x y + kyy y^2)/2,

with C the indicator of the material: the product of the half-planes of its edges (a corner, a thin wall), or the
complement of the product of their complements (`union`: an inside corner, a slot).  `pressed_field` evaluates it.

Gauss-Newton with Levenberg's damping on all unknowns at once, for no closed form of a clipped paraboloid exists,
with a weak prior on curvature for contacts smaller than the blur.
"""

from dataclasses import dataclass
from functools import lru_cache

import numba
import numpy as np

from exploration.sensing.frame import TactileImage
from exploration.sensing.surfaces.normal_equations import expect, gather, invert
from exploration.sensing.surfaces.pressed_field import fields_of, geometry, to_taxels
from primitives.arrays import Floats, Ints, frozen

CURVATURE = 0.3  # [1/mm] standard deviation of the prior: sharper than most that a pad can read
STEPS = 30
FINE = 0.03  # [deepest taxel] noise below which the model's own error at edges would show: half as wide cells
HOPE = 8.0  # times what a step promises, that all further steps together may gain
GAINED = 0.02  # [chi2] a step that gains less is the last
PLANE, ROUND, PARABOLOID = "plane", "round", "paraboloid"


@dataclass(frozen=True)
class Footprint:
    """The best parameters of a forward model for one frame."""

    parameters: Floats  # (n,); of this one d0 [mm], gx, gy, kxx, kxy, kyy [1/mm], (angle, offset) per line
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
    limit: float = np.inf,
) -> Footprint:
    """Fit from `start` (6 + 2 n,); `sides` (n,) is +1 where the material is on a line's positive side.

    `shape` is PLANE (curvature held), ROUND (kxx = kyy, kxy = 0) or PARABOLOID.  A fit is given up, unconverged,
    once its steps promise too little for chi2 to come below `limit`.
    """
    fine = len(sides) > 0 and float(image.sigma.min()) < FINE * float(image.depth.max())
    array = image.array
    grid = geometry(array.rows, array.columns, array.pitch, image.spread, image.margin, fine)
    unknown = _unknowns(shape, len(start), free_lines)
    p, covariance, chi2, count, converged, residual = _fit(
        image.depth,
        image.sigma,
        *grid,
        np.array(start, dtype=float),
        np.asarray(sides, dtype=float),
        unknown,
        union,
        steps,
        limit,
    )
    return Footprint(p, covariance, chi2, count - int(unknown.max()) - 1, converged, residual)


@lru_cache(maxsize=64)
def _unknowns(shape: str, count: int, free_lines: bool) -> Ints:
    """Which unknown each parameter is; -1 where it is held, the same twice where two are one."""
    first = {PLANE: [0, 1, 2, -1, -1, -1], ROUND: [0, 1, 2, 3, -1, 3], PARABOLOID: [0, 1, 2, 3, 4, 5]}[shape]
    lines = np.arange(count - 6) + max(first) + 1 if free_lines else np.full(count - 6, -1)
    return frozen(np.concatenate([np.array(first), lines]), np.int64)


@numba.njit(cache=True, error_model="numpy")
def _weighed(
    depth: Floats,
    sigma: Floats,
    p: Floats,
    model: Floats,
    unknown: Ints,
    normal: Floats,
    rhs: Floats,
    residual: Floats,
) -> tuple[float, int]:
    """Normal equations of the taxels and of what is expected of curvature, in the unknowns."""
    own = np.zeros((1 + len(rhs), depth.shape[0], depth.shape[1]))
    own[0] = model[0]
    for k in range(len(unknown)):
        if unknown[k] >= 0:
            own[1 + unknown[k]] += model[1 + k]
    chi2, count = gather(depth, sigma, own, normal, rhs, residual)
    for k in range(3, 6):
        if unknown[k] >= 0:
            chi2 += expect(p[k], CURVATURE, unknown[k], normal, rhs)
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
    limit: float,
) -> tuple[Floats, Floats, float, int, bool, Floats]:
    m = unknown.max() + 1
    total = len(start)
    fields = np.zeros((2 + len(sides), y.shape[1], x.shape[1]))
    model = np.zeros((1 + total, depth.shape[0], depth.shape[1]))
    normal, rhs, residual = np.zeros((m, m)), np.zeros(m), np.zeros(depth.shape)
    trial_normal, trial_rhs, trial_residual = np.zeros((m, m)), np.zeros(m), np.zeros(depth.shape)
    p = start.copy()
    fields_of(x, y, p, sides, union, fields)
    to_taxels(fields, p, to_columns, to_rows, unknown, model)
    chi2, count = _weighed(depth, sigma, p, model, unknown, normal, rhs, residual)
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
        if damping < 1.0 and chi2 - HOPE * np.dot(step, rhs) > limit:
            break
        trial = p.copy()
        for k in range(total):
            if unknown[k] >= 0:
                trial[k] += step[unknown[k]]
        fields_of(x, y, trial, sides, union, fields)
        to_taxels(fields, trial, to_columns, to_rows, unknown, model)
        new, count = _weighed(depth, sigma, trial, model, unknown, trial_normal, trial_rhs, trial_residual)
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
