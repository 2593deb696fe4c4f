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

import numba
import numpy as np

from exploration.sensing.frame import TactileImage
from exploration.sensing.surfaces.anatomy import SIGNIFICANT, STRAIGHT
from exploration.sensing.surfaces.footprint import CURVATURE, Footprint
from exploration.sensing.surfaces.levenberg import Equations, carried, descended
from exploration.sensing.surfaces.normal_equations import expect, gather
from exploration.sensing.surfaces.pressed_field import geometry
from primitives.arrays import Floats

TURNING = 0.05  # [1/mm] standard deviation of b before touch
STEEPEST = 0.04  # squared cosine of the steepest slope across
MOVED = (1e-4, 1e-6, 1e-6, 1e-5, 1e-6, 1e-4, 1e-6)  # of each parameter, for derivatives


def fit_bent_ridge(image: TactileImage, start: Floats, fine: bool = False) -> Footprint:
    """Fit from `start` (7,), (d0 [mm], s, k [1/mm], angle of the ridge, c [1/mm], m [mm], b [1/mm]).

    What it states of a tube thinner than 20 mm is only true on `fine` cells.
    """
    array = image.array
    x, y, *shares = geometry(array.rows, array.columns, array.pitch, image.spread, image.margin, fine)
    to_columns, to_rows = (np.ascontiguousarray(share[0]) for share in shares)

    def equations(p: Floats) -> Equations:
        return Equations(*_equations(image.depth, image.sigma, x, y, to_columns, to_rows, p))

    return descended(equations, np.array(start, dtype=float))


def deepest(ridge: Footprint, without: float) -> float:
    """[mm] u of the deepest place of a ridge, or `without` where that is not surely curved along it."""
    slope, bent, sigma = ridge.parameters[1], ridge.parameters[4], np.sqrt(ridge.covariance[4, 4])
    return float(slope / bent) if bent > max(STRAIGHT, SIGNIFICANT * sigma) else without


def dome(ridge: Footprint, at: float) -> Footprint:
    """The dome that touches it in second order on the ridge where u is `at` [mm]."""
    return carried(ridge, lambda p: _touching(p, at), MOVED)


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
def _equations(
    depth: Floats, sigma: Floats, x: Floats, y: Floats, to_columns: Floats, to_rows: Floats, p: Floats
) -> tuple[float, int, Floats, Floats, Floats]:
    """Those of the taxels and of what is expected."""
    n = len(p)
    fields, model = np.empty((1 + n, y.shape[1], x.shape[1])), np.empty((1 + n, *depth.shape))
    normal, rhs, residual = np.zeros((n, n)), np.zeros(n), np.zeros(depth.shape)
    _fields(x, y, p, fields)
    for k in range(1 + n):
        model[k] = to_rows @ fields[k] @ to_columns
    chi2, count = gather(depth, sigma, model, normal, rhs, residual)
    chi2 += expect(p[2], CURVATURE, 2, normal, rhs)
    chi2 += expect(p[4], CURVATURE, 4, normal, rhs)
    chi2 += expect(p[6], TURNING, 6, normal, rhs)
    return chi2, count, normal, rhs, residual
