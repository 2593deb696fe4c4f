"""How well a smooth surface explains a frame: the rival of an edge, fitted fast.

A paraboloid q(x, y) = d0 + gx x + gy y - (kxx x^2 + 2 kxy x y + kyy y^2)/2 is felt where it is positive.  Over a
taxel's blur, of variance V, q has mean q - tr(K V)/2 and variance s^2 = grad q . V grad q + tr(K V K V)/2; taken
for normal, its positive part is s ramp(q/s) (our derivation; `footprint` has the exact field, forty times slower).
Levenberg's fit starts where least squares puts the deeper half of the taxels.  An edge that gains only little over
this rival is for `line_evidence` to judge.
"""

import numba
import numpy as np

from exploration.sensing.lines.edge_model import DEAD, products, solve
from exploration.sensing.response import look_up
from primitives.arrays import Floats, Ints

UNKNOWNS = 6
STEPS = 16
GAINED = 0.1  # [chi2] a step that gains less is the last
CURVATURE = 0.3  # [1/mm] standard deviation of the prior


@numba.njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def _design(
    z: Floats,
    variance: Floats,
    gain: float,
    views: Floats,
    kinds: Ints,
    first: Ints,
    blurs: Floats,
    table: Floats,
    q: Floats,
    rows: Floats,
) -> float:
    """Fill `rows` (UNKNOWNS + 1, n): derivatives over sigma, then residuals; chi2."""
    d0, gx, gy, kxx, kxy, kyy = q[0], q[1], q[2], q[3], q[4], q[5]
    chi2 = (kxx * kxx + kxy * kxy + kyy * kyy) / CURVATURE**2
    for i in range(len(variance)):
        rows[:, i] = 0.0
        if variance[i] == np.inf:
            continue
        model = 0.0
        for k in range(first[i], first[i + 1]):
            x, y, share = views[0, k], views[1, k], views[2, k]
            vx, vy = blurs[kinds[k], 0], blurs[kinds[k], 1]
            sx, sy = gx - kxx * x - kxy * y, gy - kxy * x - kyy * y
            bend = vx * vx * kxx * kxx + 2.0 * vx * vy * kxy * kxy + vy * vy * kyy * kyy
            s = np.sqrt(vx * sx * sx + vy * sy * sy + 0.5 * bend) + 1e-9
            mean = d0 + gx * x + gy * y - 0.5 * (kxx * (x * x + vx) + kyy * (y * y + vy)) - kxy * x * y
            _, kept, left = look_up(table, mean / s, 0)
            model += share * s * left
            kept *= share
            rows[0, i] += kept
            rows[1, i] += kept * x
            rows[2, i] += kept * y
            rows[3, i] -= kept * 0.5 * (x * x + vx)
            rows[4, i] -= kept * x * y
            rows[5, i] -= kept * 0.5 * (y * y + vy)
        per_sigma = 1.0 / np.sqrt(variance[i] + (gain * max(0.0, model)) ** 2)
        r = (z[i] - model) * per_sigma
        square = r * r
        trust = 1.0
        if square > DEAD:
            trust = np.sqrt(DEAD / square)
            square = DEAD * (2.0 / trust - 1.0)
        chi2 += square
        root = np.sqrt(trust)
        for a in range(UNKNOWNS):
            rows[a, i] *= per_sigma * root
        rows[UNKNOWNS, i] = r * root
    return float(chi2)


@numba.njit(cache=True, error_model="numpy")
def rival_chi2(
    z: Floats,
    calm: Floats,
    variance: Floats,
    gain: float,
    views: Floats,
    kinds: Ints,
    first: Ints,
    blurs: Floats,
    table: Floats,
    enough: float,
) -> float:
    """chi2 of the best smooth surface that is found; the search ends below `enough`."""
    n = len(z)
    rows = np.empty((UNKNOWNS + 1, n))
    normal, rhs = np.empty((UNKNOWNS, UNKNOWNS)), np.empty(UNKNOWNS)
    lower, step = np.zeros((UNKNOWNS, UNKNOWNS)), np.zeros(UNKNOWNS)
    damped = np.empty((UNKNOWNS, UNKNOWNS))
    best = np.inf
    deepest = calm.max()
    for share in (0.5, 0.2, 0.75):
        q = np.zeros(UNKNOWNS)
        _deep_quadratic(calm, variance, views, first, share * deepest, q, rows, normal, rhs, lower)
        chi2 = _design(z, variance, gain, views, kinds, first, blurs, table, q, rows)
        damping = 1e-3
        for _ in range(STEPS):
            products(rows, UNKNOWNS, normal, rhs)
            for a in range(3, UNKNOWNS):
                normal[a, a] += 1.0 / CURVATURE**2
                rhs[a] -= q[a] / CURVATURE**2
            gained = 0.0
            while damping < 1e6:
                damped[:] = normal
                for a in range(UNKNOWNS):
                    damped[a, a] *= 1.0 + damping
                if solve(damped, rhs, UNKNOWNS, lower, step):
                    new = _design(z, variance, gain, views, kinds, first, blurs, table, q + step, rows)
                    if new < chi2:
                        q += step
                        gained = chi2 - new
                        chi2 = new
                        damping *= 0.1
                        break
                damping = max(1e-3, 10.0 * damping)
            if gained < GAINED:
                break
        best = min(best, chi2)
        if best < enough:
            break
    return best


@numba.njit(cache=True, error_model="numpy")
def _deep_quadratic(
    calm: Floats,
    variance: Floats,
    views: Floats,
    first: Ints,
    least: float,
    q: Floats,
    rows: Floats,
    normal: Floats,
    rhs: Floats,
    lower: Floats,
) -> None:
    """Fill `q` with the least-squares quadratic of the taxels deeper than `least`."""
    for i in range(len(calm)):
        use = 1.0 if calm[i] > least and variance[i] != np.inf else 0.0
        k = first[i]
        x, y = views[0, k], views[1, k]
        rows[0, i] = use
        rows[1, i] = use * x
        rows[2, i] = use * y
        rows[3, i] = -0.5 * use * x * x
        rows[4, i] = -use * x * y
        rows[5, i] = -0.5 * use * y * y
        rows[UNKNOWNS, i] = use * calm[i]
    products(rows, UNKNOWNS, normal, rhs)
    if not solve(normal, rhs, UNKNOWNS, lower, q):
        q[:] = 0.0
        q[0] = least
