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

import numba
import numpy as np

from exploration.sensing.frame import TactileImage
from exploration.sensing.surfaces.footprint import CURVATURE, FINE, Footprint
from exploration.sensing.surfaces.levenberg import Equations, carried, descended
from exploration.sensing.surfaces.normal_equations import expect, gather
from exploration.sensing.surfaces.pressed_field import geometry
from primitives.arrays import Floats

OWN = 6  # parameters before those of the ends
SHARPENING = 0.1  # [1/mm] standard deviation of b before touch: few cones are touched nearer to their apex
TURN = 0.3  # [rad] of an end from straight across
NEAREST = 0.2  # of the way to the apex that is left at the end of the pad
STEEPEST = 0.04  # squared cosine of the steepest slope across
MOVED = (1e-4, 1e-6, 1e-6, 1e-5, 1e-6, 1e-4)  # of each parameter, for derivatives


def fit_cone_flank(image: TactileImage, start: Floats, sides: Floats, limit: float = np.inf) -> Footprint:
    """Fit from `start` (6 + 2 n,), (d0 [mm], s, k [1/mm], angle of the ruling, b [1/mm], m [mm], (o, f) each).

    `sides` (n,) is +1 where an end's material lies towards greater u.  A fit is given up, unconverged, once its
    steps promise too little for chi2 to come below `limit`.
    """
    array, sides = image.array, np.asarray(sides, dtype=float)
    fine = float(image.sigma.min()) < FINE * float(image.depth.max())
    x, y, *shares = geometry(array.rows, array.columns, array.pitch, image.spread, image.margin, fine)
    to_columns, to_rows = (np.ascontiguousarray(share[0]) for share in shares)

    def equations(p: Floats) -> Equations:
        return Equations(*_equations(image.depth, image.sigma, x, y, to_columns, to_rows, p, sides))

    return descended(equations, np.array(start, dtype=float), limit)


def paraboloid(flank: Footprint, at: float) -> Footprint:
    """The ridge that touches a flank in second order where u is `at` [mm]."""
    return carried(flank, lambda p: _touching(p, at), MOVED)


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
def _equations(
    depth: Floats,
    sigma: Floats,
    x: Floats,
    y: Floats,
    to_columns: Floats,
    to_rows: Floats,
    p: Floats,
    sides: Floats,
) -> tuple[float, int, Floats, Floats, Floats]:
    """Those of the taxels and of what is expected."""
    n = len(p)
    fields, model = np.empty((1 + n, y.shape[1], x.shape[1])), np.empty((1 + n, *depth.shape))
    normal, rhs, residual = np.zeros((n, n)), np.zeros(n), np.zeros(depth.shape)
    _fields(x, y, p, sides, fields)
    for k in range(1 + n):
        model[k] = to_rows @ fields[k] @ to_columns
    chi2, count = gather(depth, sigma, model, normal, rhs, residual)
    chi2 += expect(p[2], CURVATURE, 2, normal, rhs)
    chi2 += expect(p[4], SHARPENING, 4, normal, rhs)
    for k in range(OWN + 1, n, 2):
        chi2 += expect(p[k], TURN, k, normal, rhs)
    return chi2, count, normal, rhs, residual
