"""The flank of a cone or cylinder under the pad, cut by the edges across it.

With u along the ruling that is touched, w across it, and the indentation's top at w = m,

    depth = d0 + s u - K v^2 / (1 + sqrt(1 - q K^2 v^2)),   v = w - m,   K = k / (1 + b u),   q = 1 - (b/k)^2,

which is exactly a cone's section by the planes across its ruling: k is the curvature there at u = 0, -1/b the
place of the apex, b/k the tangent of the half-angle (our derivation); b = 0 is a cylinder.  A paraboloid knows no
curvature that grows along its ridge: on a cone of 20 mm to the apex it leaves chi2 many times its degrees of
freedom, and even a flat strip explains more.  Ends cut it where side (U cos f + w sin f - o) < 0, with
U = u + b v^2 / 2 (1 + b u) even along a cone's own circles.

Levenberg's steps on all unknowns, with a weak prior on k, b and the turn f of each end.
"""

from dataclasses import dataclass

import numba
import numpy as np

from exploration.sensing.frame import TactileImage
from exploration.sensing.surfaces.footprint import CURVATURE, FINE, HOPE, Footprint
from exploration.sensing.surfaces.normal_equations import expect, gather, invert
from exploration.sensing.surfaces.pressed_field import geometry
from primitives.arrays import Floats

OWN = 6  # parameters before those of the ends
SHARPENING = 0.1  # [1/mm] standard deviation of b before touch: few cones are touched nearer to their apex
TURN = 0.3  # [rad] of an end from straight across
NEAREST = 0.2  # of the way to the apex that is left at the end of the pad
STEEPEST = 0.04  # squared cosine of the steepest slope across
STEPS = 40
GAINED = 0.02  # [chi2] a step that gains less is the last
MOVED = (1e-4, 1e-6, 1e-6, 1e-5, 1e-6, 1e-4)  # of each parameter, for derivatives


@dataclass(frozen=True)
class ConeFlank:
    """The best flank for one frame."""

    parameters: (
        Floats  # (6 + 2 n,) d0 [mm], s, k [1/mm], angle of the ruling [rad], b [1/mm], m [mm], (o, f) each
    )
    covariance: Floats  # (6 + 2 n, 6 + 2 n)
    chi2: float  # Huber's
    dof: int
    converged: bool
    residual: Floats  # (rows, columns) [sigma]

    def paraboloid(self, at: float) -> Footprint:
        """The ridge that touches it in second order where u is `at` [mm]."""
        p = self.parameters[:OWN]
        turn = np.empty((6, OWN))
        for k in range(OWN):
            step = np.zeros(OWN)
            step[k] = MOVED[k]
            turn[:, k] = (_touching(p + step, at) - _touching(p - step, at)) / (2 * MOVED[k])
        covariance = turn @ self.covariance[:OWN, :OWN] @ turn.T
        return Footprint(_touching(p, at), covariance, self.chi2, self.dof, self.converged, self.residual)


def fit_cone_flank(image: TactileImage, start: Floats, sides: Floats, limit: float = np.inf) -> ConeFlank:
    """Fit from `start` (6 + 2 n,); `sides` (n,) is +1 where an end's material lies towards greater u.

    A fit is given up, unconverged, once its steps promise too little for chi2 to come below `limit`.
    """
    array = image.array
    fine = float(image.sigma.min()) < FINE * float(image.depth.max())
    grid = geometry(array.rows, array.columns, array.pitch, image.spread, image.margin, fine)
    p, covariance, chi2, count, converged, residual = _fit(
        image.depth,
        image.sigma,
        grid[0],
        grid[1],
        np.ascontiguousarray(grid[2][0]),
        np.ascontiguousarray(grid[3][0]),
        np.array(start, dtype=float),
        np.asarray(sides, dtype=float),
        limit,
    )
    return ConeFlank(p, covariance, chi2, count - len(p), converged, residual)


def _touching(p: Floats, at: float) -> Floats:
    """Coefficients (6,) of the paraboloid."""
    d0, slope, k, angle, b, middle = p
    along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    bent = k / (1.0 + b * at)
    gx, gy = slope * along + bent * middle * across
    x, y = across
    return np.array([d0 - 0.5 * bent * middle**2, gx, gy, bent * x * x, bent * x * y, bent * y * y])


@numba.njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def _fields(x: Floats, y: Floats, p: Floats, sides: Floats, out: Floats) -> None:
    """Means over cells (1 + 6 + 2 n, ny, nx): the indentation, and its derivatives to `p`."""
    d0, slope, k, b, middle = p[0], p[1], p[2], p[4], p[5]
    c, s = np.cos(p[3]), np.sin(p[3])
    steeper = b / k if abs(b) < abs(k) else 1.0
    q, to_k = 1.0 - steeper * steeper, 2.0 * steeper / k if abs(b) < abs(k) else 0.0
    ends = len(sides)
    turns = np.empty((ends, 2))
    for e in range(ends):
        turns[e, 0], turns[e, 1] = np.cos(p[OWN + 1 + 2 * e]), np.sin(p[OWN + 1 + 2 * e])
    for i in range(y.shape[1]):
        for j in range(x.shape[1]):
            hx, hy = x[1, j], y[1, i]
            u, w = c * x[0, j] + s * y[0, i], c * y[0, i] - s * x[0, j]
            v = w - middle
            left = max(NEAREST, 1.0 + b * u)
            bent = k / left
            root = np.sqrt(max(STEEPEST, 1.0 - q * bent * bent * v * v))
            drop = bent * v * v / (1.0 + root)
            along, across = slope + b * drop / left, -bent * v / root
            depth = d0 + slope * u - drop - bent * ((s * hx) ** 2 + (c * hy) ** 2) / 24.0
            half = 0.5 * np.hypot((along * c - across * s) * hx, (along * s + across * c) * hy) + 1e-12
            if depth <= -half:
                out[:, i, j] = 0.0
                continue
            touched = 1.0
            if depth < half:
                touched = 0.5 * (depth + half) / half
                depth = 0.5 * (depth + half) * touched
            cover, turned = 1.0, 0.0
            for e in range(ends):
                fc, fs = turns[e]
                even = u + 0.5 * b * v * v / left
                reach = 0.5 * np.hypot((fc * c - fs * s) * hx, (fc * s + fs * c) * hy)
                t = 0.5 + 0.5 * sides[e] * (even * fc + w * fs - p[OWN + 2 * e]) / reach
                steep = 0.5 * sides[e] / reach if 0.0 < t < 1.0 else 0.0
                t = min(1.0, max(0.0, t))
                for m in range(e):
                    out[1 + OWN + 2 * m, i, j] *= t
                    out[2 + OWN + 2 * m, i, j] *= t
                across_end = w * fc - even * fs
                out[1 + OWN + 2 * e, i, j] = -depth * cover * steep
                out[2 + OWN + 2 * e, i, j] = depth * cover * steep * across_end
                turned = turned * t + depth * cover * steep * across_end
                cover *= t
            share = touched * cover
            sharper = drop / bent - v * v / root if bent != 0.0 else -0.5 * v * v
            rounder = -0.5 * bent**3 * v**4 / (root * (1.0 + root) ** 2)
            out[0, i, j] = depth * cover
            out[1, i, j] = share
            out[2, i, j] = share * u
            out[3, i, j] = share * (sharper / left + rounder * to_k * steeper)
            out[4, i, j] = share * (along * w - across * u) + turned
            out[5, i, j] = -share * (sharper * bent * u / left + rounder * to_k)
            out[6, i, j] = -share * across


@numba.njit(cache=True, error_model="numpy")
def _weighed(
    depth: Floats,
    sigma: Floats,
    x: Floats,
    y: Floats,
    to_columns: Floats,
    to_rows: Floats,
    p: Floats,
    sides: Floats,
    fields: Floats,
    normal: Floats,
    rhs: Floats,
    residual: Floats,
) -> tuple[float, int]:
    """Normal equations of the taxels and of what is expected."""
    n = len(p)
    model = np.empty((1 + n, depth.shape[0], depth.shape[1]))
    _fields(x, y, p, sides, fields)
    for k in range(1 + n):
        model[k] = to_rows @ fields[k] @ to_columns
    chi2, count = gather(depth, sigma, model, normal, rhs, residual)
    chi2 += expect(p[2], CURVATURE, 2, normal, rhs)
    chi2 += expect(p[4], SHARPENING, 4, normal, rhs)
    for k in range(OWN + 1, n, 2):
        chi2 += expect(p[k], TURN, k, normal, rhs)
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
    limit: float,
) -> tuple[Floats, Floats, float, int, bool, Floats]:
    m = len(start)
    normal, rhs, residual = np.zeros((m, m)), np.zeros(m), np.zeros(depth.shape)
    next_normal, next_rhs, next_residual = np.zeros((m, m)), np.zeros(m), np.zeros(depth.shape)
    grid, fields = (x, y, to_columns, to_rows), np.empty((1 + m, y.shape[1], x.shape[1]))
    p = start.copy()
    chi2, count = _weighed(depth, sigma, *grid, p, sides, fields, normal, rhs, residual)
    damping, converged = 1e-3, False
    for _ in range(STEPS):
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
        trial = p + step
        new, count = _weighed(depth, sigma, *grid, trial, sides, fields, next_normal, next_rhs, next_residual)
        if new < chi2:
            converged = chi2 - new < GAINED
            p, chi2 = trial, new
            normal[:], rhs[:], residual[:] = next_normal, next_rhs, next_residual
            damping *= 0.1
        else:
            converged = np.dot(step, rhs) < GAINED
            damping = max(1e-3, damping * 10.0)
        if converged or damping > 1e8:
            break
    ok, covariance = invert(normal)
    return p, covariance, chi2, count, converged and ok, residual
