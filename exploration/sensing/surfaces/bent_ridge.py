"""A ridge that turns under the pad, as a ring's does, where a paraboloid's straight one explains no frame.

With u along the ridge at the pad's center and w across it,

    depth = d0 + s u - c u^2 / 2 - k v^2 / (1 + sqrt(1 - k^2 v^2)),
    v = (2 q - b (q^2 + u^2)) / (1 + sqrt((1 - b q)^2 + b^2 u^2)),   q = w - m,

v the distance from the circle that turns by b in the pad's plane, k the ridge's curvature across it and c that
along it: a torus that lies flat, exactly, with b = 1/R, and any other to the second order in u (our derivation).
A paraboloid's ridge runs through the middle of such a contact's crescent, 0.05 mm too low on a ring of 70 mm and
13 mm thick; and three lines round it explain a flat face as well.

Levenberg's steps on all unknowns, with weak priors on k, c and b.
"""

from dataclasses import dataclass

import numba
import numpy as np

from exploration.sensing.frame import TactileImage
from exploration.sensing.surfaces.anatomy import SIGNIFICANT, STRAIGHT
from exploration.sensing.surfaces.footprint import CURVATURE, Footprint
from exploration.sensing.surfaces.normal_equations import expect, gather, invert
from exploration.sensing.surfaces.pressed_field import geometry
from primitives.arrays import Floats, frozen

TURNING = 0.05  # [1/mm] standard deviation of b before touch
STEEPEST = 0.04  # squared cosine of the steepest slope across
STEPS = 40
GAINED = 0.02  # [chi2] a step that gains less is the last
_UNKNOWNS = 7
_MOVED = (1e-4, 1e-6, 1e-6, 1e-5, 1e-6, 1e-4, 1e-6)  # of each parameter, for derivatives


@dataclass(frozen=True)
class BentRidge:
    """The best one for a frame."""

    parameters: Floats  # (7,) d0 [mm], s, k [1/mm], angle of the ridge [rad], c [1/mm], m [mm], b [1/mm]
    covariance: Floats  # (7, 7)
    chi2: float  # Huber's
    dof: int
    converged: bool
    residual: Floats  # (rows, columns) [sigma]

    def deepest(self, without: float) -> float:
        """[mm] u of the deepest place of its ridge, or `without` where that is not surely curved along it."""
        slope, bent, sigma = self.parameters[1], self.parameters[4], np.sqrt(self.covariance[4, 4])
        return float(slope / bent) if bent > max(STRAIGHT, SIGNIFICANT * sigma) else without

    def dome(self, at: float) -> Footprint:
        """The dome that touches it in second order on its ridge where u is `at` [mm]."""
        turn = np.empty((6, _UNKNOWNS))
        for k, moved in enumerate(_MOVED):
            step = np.zeros(_UNKNOWNS)
            step[k] = moved
            turn[:, k] = (_touching(self.parameters + step, at) - _touching(self.parameters - step, at)) / (
                2 * moved
            )
        covariance = turn @ self.covariance @ turn.T
        touching = _touching(self.parameters, at)
        return Footprint(touching, covariance, self.chi2, self.dof, self.converged, self.residual)


def fit_bent_ridge(image: TactileImage, start: Floats, fine: bool = False) -> BentRidge:
    """Fit from `start` (7,); what it states of a tube thinner than 20 mm is only true on `fine` cells."""
    array = image.array
    x, y, to_columns, to_rows = geometry(
        array.rows, array.columns, array.pitch, image.spread, image.margin, fine
    )
    p, covariance, chi2, count, converged, residual = _fit(
        image.depth,
        image.sigma,
        x,
        y,
        np.ascontiguousarray(to_columns[0]),
        np.ascontiguousarray(to_rows[0]),
        np.array(start, dtype=float),
        frozen([CURVATURE, CURVATURE, TURNING]),
    )
    return BentRidge(p, covariance, chi2, count - _UNKNOWNS, converged, residual)


def _touching(p: Floats, at: float) -> Floats:
    """Coefficients (6,) of the dome."""
    d0, slope, k, angle, c, middle, b = p
    along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    sine = np.clip(b * at, -1.0, 1.0)
    cosine = np.sqrt(1.0 - sine**2)
    place = at * along + (middle + b * at**2 / (1.0 + cosine)) * across
    turned = cosine * across - sine * along
    bent = k * np.outer(turned, turned) + c * np.outer(along, along)
    sloped = (slope - c * at) * along
    level = d0 + slope * at - 0.5 * c * at**2 - sloped @ place - 0.5 * place @ bent @ place
    return np.array([level, *(sloped + bent @ place), bent[0, 0], bent[0, 1], bent[1, 1]])


@numba.njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def _fields(x: Floats, y: Floats, p: Floats, out: Floats) -> None:
    """Means over cells (1 + 7, ny, nx): the indentation, and its derivatives to `p`."""
    d0, slope, k, bend_along, middle, turning = p[0], p[1], p[2], p[4], p[5], p[6]
    c, s = np.cos(p[3]), np.sin(p[3])
    for i in range(y.shape[1]):
        for j in range(x.shape[1]):
            hx, hy = x[1, j], y[1, i]
            u, w = c * x[0, j] + s * y[0, i], c * y[0, i] - s * x[0, j]
            q = w - middle
            far = np.hypot(1.0 - turning * q, turning * u)
            v = (2.0 * q - turning * (q * q + u * u)) / (1.0 + far)
            to_w, to_u = (1.0 - turning * q) / far, -turning * u / far
            to_turn = (q * to_w + u * to_u - v) / turning if abs(turning) > STRAIGHT else -0.5 * u * u
            root = np.sqrt(max(STEEPEST, 1.0 - k * k * v * v))
            drop = k * v * v / (1.0 + root)
            steep = -k * v / root
            along, across = slope - bend_along * u + steep * to_u, steep * to_w
            depth = d0 + slope * u - 0.5 * bend_along * u * u - drop
            depth -= k * ((s * hx) ** 2 + (c * hy) ** 2) / (24.0 * root**3)
            half = 0.5 * np.hypot((along * c - across * s) * hx, (along * s + across * c) * hy) + 1e-12
            if depth <= -half:
                out[:, i, j] = 0.0
                continue
            share = 1.0
            if depth < half:
                share = 0.5 * (depth + half) / half
                depth = 0.5 * (depth + half) * share
            out[0, i, j] = depth
            out[1, i, j] = share
            out[2, i, j] = share * u
            out[3, i, j] = share * (drop / k - v * v / root if k != 0.0 else -0.5 * v * v)
            out[4, i, j] = share * (along * w - across * u)
            out[5, i, j] = -0.5 * share * u * u
            out[6, i, j] = -share * across
            out[7, i, j] = share * steep * to_turn


@numba.njit(cache=True, error_model="numpy")
def _weighed(
    depth: Floats,
    sigma: Floats,
    x: Floats,
    y: Floats,
    to_columns: Floats,
    to_rows: Floats,
    p: Floats,
    expected: Floats,
    fields: Floats,
    normal: Floats,
    rhs: Floats,
    residual: Floats,
) -> tuple[float, int]:
    """Normal equations of the taxels and of what is expected."""
    n = len(p)
    model = np.empty((1 + n, depth.shape[0], depth.shape[1]))
    _fields(x, y, p, fields)
    for k in range(1 + n):
        model[k] = to_rows @ fields[k] @ to_columns
    chi2, count = gather(depth, sigma, model, normal, rhs, residual)
    for k in range(3):
        at = 2 * (k + 1)
        chi2 += expect(p[at], expected[k], at, normal, rhs)
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
    expected: Floats,
) -> tuple[Floats, Floats, float, int, bool, Floats]:
    m = len(start)
    normal, rhs, residual = np.zeros((m, m)), np.zeros(m), np.zeros(depth.shape)
    next_normal, next_rhs, next_residual = np.zeros((m, m)), np.zeros(m), np.zeros(depth.shape)
    grid, fields = (x, y, to_columns, to_rows), np.empty((1 + m, y.shape[1], x.shape[1]))
    p = start.copy()
    chi2, count = _weighed(depth, sigma, *grid, p, expected, fields, normal, rhs, residual)
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
        trial = p + step
        new, count = _weighed(
            depth, sigma, *grid, trial, expected, fields, next_normal, next_rhs, next_residual
        )
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
