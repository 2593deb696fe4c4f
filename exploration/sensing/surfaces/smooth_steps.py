"""Levenberg's steps of a smooth contact in its shape's own unknowns, on the whole forward model.

With N and b the normal equations in the six coefficients p, and T = dp/du carrying a shape's unknowns u, the step
of Gauss and Newton is that of (T^t N T) du = T^t b (our derivation).  The Jacobian is the paraboloid's own: what
the bend to a circle changes in it is second order, and leaves the estimate without bias.
"""

import numba
import numpy as np

from exploration.sensing.surfaces.footprint import CURVATURE, GAINED
from exploration.sensing.surfaces.normal_equations import HUBER, invert
from exploration.sensing.surfaces.pressed_field import fields_of, to_taxels
from exploration.sensing.surfaces.smooth_shapes import moved, tangents
from primitives.arrays import Floats, frozen

_ALL = frozen(np.arange(6), np.int64)
HOPE = 3.0  # times what a step promises, that all further steps together may gain


@numba.njit(cache=True, error_model="numpy")
def fit_from(
    depth: Floats,
    precision: Floats,
    x: Floats,
    y: Floats,
    to_columns: Floats,
    to_rows: Floats,
    start: Floats,
    shape: int,
    steps: int,
    limit: float,
) -> tuple[Floats, Floats, float, int, bool, Floats]:
    """Levenberg's steps from `start`; coefficients, their covariance, chi2, taxels, converged, residual."""
    fields = np.zeros((2, y.shape[1], x.shape[1]))
    model = np.zeros((7, depth.shape[0], depth.shape[1]))
    normal, rhs, residual = np.zeros((6, 6)), np.zeros(6), np.zeros(depth.shape)
    trial_normal, trial_rhs, trial_residual = np.zeros((6, 6)), np.zeros(6), np.zeros(depth.shape)
    none = np.empty(0)
    p = start.copy()
    fields_of(x, y, p, none, len(none) > 0, fields)
    to_taxels(fields, p, to_columns, to_rows, _ALL, model)
    chi2 = _weighed(depth, precision, p, model, normal, rhs, residual)
    count = int(np.sum(precision > 0.0))
    damping = 1e-4
    converged = False
    for _ in range(steps):
        toward = tangents(p, shape)
        own = toward.T @ (normal @ toward)
        slope = toward.T @ rhs
        for a in range(len(slope)):
            own[a, a] = own[a, a] * (1.0 + damping) + 1e-12
        ok, inverse = invert(own)
        if not ok:
            damping = max(1e-3, damping * 10.0)
            if damping > 1e6:
                break
            continue
        step = inverse @ slope
        promised = np.dot(step, slope)
        if chi2 - HOPE * promised > limit:
            break
        if promised < GAINED and damping < 1.0:
            p = moved(p, step, shape)
            converged = True
            break
        trial = moved(p, step, shape)
        fields_of(x, y, trial, none, len(none) > 0, fields)
        to_taxels(fields, trial, to_columns, to_rows, _ALL, model)
        new = _weighed(depth, precision, trial, model, trial_normal, trial_rhs, trial_residual)
        if new < chi2:
            gained = chi2 - new
            p, chi2 = trial, new
            normal, trial_normal = trial_normal, normal
            rhs, trial_rhs = trial_rhs, rhs
            residual, trial_residual = trial_residual, residual
            damping = damping * 0.1 if damping > 1e-6 else 0.0
            if gained < GAINED * max(1.0, chi2 / count):
                converged = True
                break
        else:
            if promised < GAINED * max(1.0, chi2 / count):
                converged = True
                break
            damping = max(1e-3, damping * 10.0)
            if damping > 1e8:
                break
    toward = tangents(p, shape)
    ok, inverse = invert(toward.T @ (normal @ toward))
    covariance = toward @ inverse @ toward.T if ok else np.zeros((6, 6))
    return p, covariance, chi2, count, converged and ok, residual


@numba.njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def _weighed(
    depth: Floats, precision: Floats, p: Floats, model: Floats, normal: Floats, rhs: Floats, residual: Floats
) -> float:
    """Normal equations of the six coefficients, and Huber's chi2; `model` becomes the weighted Jacobian."""
    n = depth.size
    felt, weight, field, left = depth.ravel(), precision.ravel(), model[0].ravel(), residual.ravel()
    jacobian = model[1:].reshape(6, n)
    chi2 = 0.0
    for i in range(n):
        r = (felt[i] - field[i]) * weight[i]
        left[i] = r
        size = abs(r)
        trust = weight[i]
        if size > HUBER:
            chi2 += HUBER * (2.0 * size - HUBER)
            share = np.sqrt(HUBER / size)
            trust *= share
            r *= share
        else:
            chi2 += r * r
        field[i] = r
        for a in range(6):
            jacobian[a, i] *= trust
    for a in range(6):
        total = 0.0
        for i in range(n):
            total += jacobian[a, i] * field[i]
        rhs[a] = total
        for b in range(a + 1):
            total = 0.0
            for i in range(n):
                total += jacobian[a, i] * jacobian[b, i]
            normal[a, b] = total
            normal[b, a] = total
    for a in range(3, 6):
        chi2 += (p[a] / CURVATURE) ** 2
        rhs[a] -= p[a] / CURVATURE**2
        normal[a, a] += 1.0 / CURVATURE**2
    return chi2
