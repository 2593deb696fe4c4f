"""One straight edge as every taxel sees it, and how that changes with its eight numbers, in one pass.

A half-plane of material with depth a + b t + c v at t > 0, t the distance into the material and v the coordinate
along the edge, on a background h.  With w the response's width across the edge and (edge, ramp) its tables,

    Q(t, v) = (A + c v) edge(t/w) + b w ramp(t/w),     depth = h + Q.

Three things make it real (our derivations):

- The second face may be less than vertical.  It falls by g = tan(pi - dihedral + atan b) per mm, and so reaches
  the undeformed skin l = (A + c v) / g outside the edge: (A + c v) edge(t/w) becomes
  g w (ramp((t + l)/w) - ramp(t/w)).
- A tilted plateau may run out within the pad.  Given that a point of the rubber's blur lies on the material, the
  plateau there has mean q = Q / edge and variance s^2 = w^2 (c^2 + b^2 edge(t/w)); the mean of max(0, plateau)
  is then s ramp(q/s), which replaces q.
- Where the skin ends, a taxel is the weighted sum of several `views` of an endless skin (see `skin_views`).

A gain that is known to a relative sigma g makes noise g times the depth of the model, never of the reading: else
taxels of low gain would count more and pull the plateau down.
"""

import numba
import numpy as np

from exploration.sensing.response import look_up
from primitives.arrays import Floats, Ints

ANGLE, OFFSET, HEIGHT, RISE, ALONG, BACKGROUND = range(6)
UNKNOWNS = 6
STEEP = 20.0  # a second face steeper than this is vertical to any taxel
CLIPPED = 4.0  # [standard deviations] above zero, from which no part of the plateau has run out
HUBER = 3.0  # [sigma] residuals beyond count by their size, while the line is still on its way
DEAD = 14.0  # [chi2] -2 ln of the odds that a taxel is dead rather than noisy: 1 % over a plateau of 20 sigma


@numba.njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def design(
    depth: Floats,
    variance: Floats,
    certainty: Floats,
    gain: float,
    views: Floats,
    kinds: Ints,
    first: Ints,
    blurs: Floats,
    table: Floats,
    p: Floats,
    side: float,
    fall: float,
    settled: bool,
    widths: Floats,
    rows: Floats,
) -> tuple[float, int]:
    """Fill the first of `rows` (m, n) with derivatives over sigma, the last with residuals; chi2 and its taxels.

    The row after the unknowns says how far each taxel is trusted.

    `variance` (n,) is of the noise, infinite where dead, and `certainty` (n,) one over its root; `views` (3, k)
    x, y and weight, `kinds` (k,) which of `blurs` (m, 2) each has, `first` (n + 1,) the views of each taxel;
    `fall` is the angle pi - dihedral.
    """
    ca, sa = np.cos(p[ANGLE]), np.sin(p[ANGLE])
    offset, height, rise, along, background = p[1], p[2], p[3], p[4], p[5]
    for m in range(len(blurs)):
        widths[m] = np.sqrt(blurs[m, 0] * sa * sa + blurs[m, 1] * ca * ca)
    g = np.tan(fall + np.arctan(rise))
    sloped = 0.0 < g < STEEP
    chi2 = 0.0
    count = 0
    for i in range(len(variance)):
        if variance[i] == np.inf:
            rows[: UNKNOWNS + 1, i] = 0.0
            rows[-1, i] = 0.0
            continue
        model, by_angle, by_offset, by_height, by_rise, by_along = background, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(first[i], first[i + 1]):
            x, y, share = views[0, k], views[1, k], views[2, k]
            w = widths[kinds[k]]
            across, v = ca * y - sa * x, ca * x + sa * y
            t = side * (across - offset)
            change, step, slant = look_up(table, t / w, 0)
            change, slant = change / w, slant * w
            a = height + along * v
            if sloped and a > 0.0:
                _, outer, outer_slant = look_up(table, (t + a / g) / w, 0)
                q = rise * slant + g * (outer_slant * w - slant)
                by_t = rise * step + g * (outer - step)
                step = outer
            else:
                q = a * step + rise * slant
                by_t = a * change + rise * step
            by_a, by_b = step, slant
            if step > 1e-9:
                spread = w * w * (along * along + rise * rise * step)
                mean = q / step
                if mean <= 0.0 or mean * mean < CLIPPED * CLIPPED * spread:
                    s = np.sqrt(spread) + 1e-12
                    _, kept, left = look_up(table, mean / s, 0)
                    by_t = kept * by_t + change * (left * s - kept * mean)
                    q = step * left * s
                    by_a *= kept
                    by_b *= kept
            model += share * q
            by_angle += share * (along * across * by_a - side * v * by_t)
            by_offset -= share * side * by_t
            by_height += share * by_a
            by_rise += share * by_b
            by_along += share * v * by_a
        per_sigma = certainty[i]
        if gain > 0.0:
            per_sigma = 1.0 / np.sqrt(variance[i] + (gain * max(0.0, model)) ** 2)
        r = (depth[i] - model) * per_sigma
        square = r * r
        count += 1
        trust, root = 1.0, 1.0
        if settled:
            if square > 5.0:
                odds = np.exp(0.5 * (min(square, 100.0) - DEAD))
                trust = 1.0 / (1.0 + odds)
                root = np.sqrt(trust)
                if trust < 0.5:
                    count -= 1
                    square = 0.0
                else:
                    square -= 2.0 * np.log(1.0 + odds)
        elif square > HUBER * HUBER:
            size = abs(r)
            trust = HUBER / size
            root = np.sqrt(trust)
            square = HUBER * (2.0 * size - HUBER)
        chi2 += square
        rows[UNKNOWNS, i] = trust
        scale = per_sigma * root
        rows[ANGLE, i] = by_angle * scale
        rows[OFFSET, i] = by_offset * scale
        rows[HEIGHT, i] = by_height * scale
        rows[RISE, i] = by_rise * scale
        rows[ALONG, i] = by_along * scale
        rows[BACKGROUND, i] = scale
        rows[-1, i] = r * root
    return chi2, count


@numba.njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def products(rows: Floats, m: int, normal: Floats, rhs: Floats) -> None:
    """Normal matrix and right-hand side of the first `m` rows against the last."""
    n = rows.shape[1]
    last = rows.shape[0] - 1
    for a in range(m):
        for b in range(a + 1):
            total = 0.0
            for i in range(n):
                total += rows[a, i] * rows[b, i]
            normal[a, b] = total
            normal[b, a] = total
        total = 0.0
        for i in range(n):
            total += rows[a, i] * rows[last, i]
        rhs[a] = total


@numba.njit(cache=True, error_model="numpy")
def solve(normal: Floats, rhs: Floats, m: int, lower: Floats, out: Floats) -> bool:
    """Fill `out` with normal^-1 rhs by Cholesky, of the leading m; false where that is not definite."""
    for i in range(m):
        for j in range(i + 1):
            s = normal[i, j]
            for k in range(j):
                s -= lower[i, k] * lower[j, k]
            if i == j:
                if not s > 1e-10 * normal[i, i]:
                    return False
                lower[i, i] = np.sqrt(s)
            else:
                lower[i, j] = s / lower[j, j]
    for i in range(m):
        s = rhs[i]
        for k in range(i):
            s -= lower[i, k] * out[k]
        out[i] = s / lower[i, i]
    for i in range(m - 1, -1, -1):
        s = out[i]
        for k in range(i + 1, m):
            s -= lower[k, i] * out[k]
        out[i] = s / lower[i, i]
    return True
