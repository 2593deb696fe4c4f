"""Whether one straight edge, and nothing else, explains a frame.

An edge is sure when (our derivation) chi2 is that of noise; no 3 x 3 block of residuals stands out, and few
taxels are taken for dead; the plateau need not curve; and the step is not the rim of a smooth surface.

Were it one, the surface a + b t - k t^2/2 would reach zero some delta outside: a = b delta + k delta^2/2.  Seen
from the step, such a rim lies delta/2 further out and is delta^2/(6 w^2) wider than an edge, to first order.  Over
all delta, that must be far from what the frame says of (a, b, k, offset, width), all of them free at once.
"""

import numba
import numpy as np

from exploration.sensing.lines.edge_model import (
    ALONG,
    BACKGROUND,
    HEIGHT,
    OFFSET,
    RISE,
    UNKNOWNS,
    products,
)
from exploration.sensing.response import look_up
from exploration.sensing.surfaces.normal_equations import invert
from primitives.arrays import Floats, Ints

STANDS_OUT = 4.5  # [sigma] of the mean of a 3 x 3 block of residuals
UNTOUCHED = 4.0  # [sigma] within which a dead taxel reads zero
FEW = 0.06  # of the taxels may be dead

EXTRA = 4  # width, and three curvatures of the plateau
WIDTH, BEND, TWIST, SAG = range(UNKNOWNS, UNKNOWNS + EXTRA)


@numba.njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def freed(
    views: Floats,
    kinds: Ints,
    first: Ints,
    blurs: Floats,
    table: Floats,
    p: Floats,
    side: float,
    middle: float,
    rows: Floats,
) -> None:
    """Fill the rows of `EXTRA` after a polish: derivatives to the width and to curvatures about `middle`."""
    ca, sa = np.cos(p[0]), np.sin(p[0])
    for i in range(len(first) - 1):
        wide, bend, twist, sag = 0.0, 0.0, 0.0, 0.0
        for k in range(first[i], first[i + 1]):
            x, y, share = views[0, k], views[1, k], views[2, k]
            m = kinds[k]
            w = np.sqrt(blurs[m, 0] * sa * sa + blurs[m, 1] * ca * ca)
            v = ca * x + sa * y
            u = side * (ca * y - sa * x - p[OFFSET]) / w
            change, step, slant = look_up(table, u, 0)
            _, _, curve = look_up(table, u, 1)
            a = p[HEIGHT] + p[ALONG] * v
            wide += share * (p[RISE] * w * (slant - u * step) - a * u * change)
            bend += share * w * w * curve
            twist += share * (v - middle) * w * slant
            sag += share * 0.5 * (v - middle) ** 2 * step
        scale = rows[BACKGROUND, i]
        rows[WIDTH, i] = wide * scale
        rows[BEND, i] = bend * scale
        rows[TWIST, i] = twist * scale
        rows[SAG, i] = sag * scale


@numba.njit(cache=True, inline="always")
def _quadratic_form(
    d0: float, d1: float, d2: float, a: float, b: float, c: float, e: float, f: float, g: float
) -> float:
    """d^T M^-1 d of the symmetric M = [[a, b, c], [b, e, f], [c, f, g]]."""
    m00, m01, m02 = e * g - f * f, c * f - b * g, b * f - c * e
    m11, m12, m22 = a * g - c * c, b * c - a * f, a * e - b * b
    determinant = a * m00 + b * m01 + c * m02
    total = d0 * d0 * m00 + d1 * d1 * m11 + d2 * d2 * m22
    return (total + 2.0 * (d0 * d1 * m01 + d0 * d2 * m02 + d1 * d2 * m12)) / determinant


@numba.njit(cache=True, error_model="numpy")
def rim_evidence(
    rows: Floats, p: Floats, side: float, middle: float, width: float, ground: float
) -> tuple[float, float, float]:
    """[chi2] that curvature gains; [sigma] of the width; [chi2] by which no smooth rim explains the step."""
    m = UNKNOWNS + EXTRA
    normal, rhs = np.empty((m, m)), np.empty(m)
    products(rows, m, normal, rhs)
    normal[BACKGROUND, BACKGROUND] += ground
    rhs[BACKGROUND] -= ground * p[BACKGROUND]
    ok, covariance = invert(normal)
    if not ok:
        return 0.0, 0.0, 0.0
    step = np.zeros(m)
    for i in range(m):
        for j in range(m):
            step[i] += covariance[i, j] * rhs[j]
    bent = _quadratic_form(
        step[BEND],
        step[TWIST],
        step[SAG],
        covariance[BEND, BEND],
        covariance[BEND, TWIST],
        covariance[BEND, SAG],
        covariance[TWIST, TWIST],
        covariance[TWIST, SAG],
        covariance[SAG, SAG],
    )
    blurred = step[WIDTH] / np.sqrt(covariance[WIDTH, WIDTH])
    a = p[HEIGHT] + step[HEIGHT] + middle * (p[ALONG] + step[ALONG])
    b, k = p[RISE] + step[RISE], step[BEND]
    of_a = covariance[HEIGHT] + middle * covariance[ALONG]
    least = np.inf
    for n in range(1, 25):
        delta = 0.2 * n * width
        half = 0.5 * delta * delta
        row = of_a - delta * covariance[RISE] + half * covariance[BEND]
        least = min(
            least,
            _quadratic_form(
                a - b * delta + k * half,
                step[WIDTH] - delta * delta / (6.0 * width * width),
                step[OFFSET] + side * 0.5 * delta,
                row[HEIGHT] + middle * row[ALONG] - delta * row[RISE] + half * row[BEND],
                row[WIDTH],
                row[OFFSET],
                covariance[WIDTH, WIDTH],
                covariance[WIDTH, OFFSET],
                covariance[OFFSET, OFFSET],
            ),
        )
    return bent, blurred, least


@numba.njit(cache=True, error_model="numpy")
def explains(z: Floats, quiet: float, rows: Floats, height: int, columns: int) -> bool:
    """Whether residuals stand alone: no block of them stands out, and few taxels are taken for dead.

    Two neighbors both dead must read nothing and lie off the pad's rim, where a further edge would cut them off.
    """
    trust, rest = rows[UNKNOWNS], rows[-1]
    dead = 0
    for i in range(height):
        for j in range(columns):
            k = i * columns + j
            if rows[BACKGROUND, k] > 0.0 and trust[k] < 0.5:
                dead += 1
                for n, inside in ((k + 1, j + 1 < columns), (k + columns, i + 1 < height)):
                    if inside and trust[n] < 0.5 and rows[BACKGROUND, n] > 0.0:
                        rim = i == 0 or j == 0 or n // columns == height - 1 or n % columns == columns - 1
                        if rim or max(abs(z[k]), abs(z[n])) > UNTOUCHED * quiet:
                            return False
            total, count = 0.0, 0
            for a in range(max(0, i - 1), min(height, i + 2)):
                for b in range(max(0, j - 1), min(columns, j + 2)):
                    total += rest[a * columns + b]
                    count += 1
            if total * total > STANDS_OUT * STANDS_OUT * count:
                return False
    return dead <= FEW * len(z)


@numba.njit(cache=True, error_model="numpy")
def seen_length(p: Floats, side: float, half_x: float, half_y: float, least: float) -> tuple[float, float]:
    """Where along its direction [mm] the line lies on the pad, with a plateau of at least `least` [mm]."""
    ca, sa = np.cos(p[0]), np.sin(p[0])
    low, high = -np.inf, np.inf
    for foot, d, half in ((-p[1] * sa, ca, half_x), (p[1] * ca, sa, half_y)):
        if abs(d) < 1e-12:
            if abs(foot) > half:
                return 0.0, 0.0
            continue
        a, b = (-half - foot) / d, (half - foot) / d
        low, high = max(low, min(a, b)), min(high, max(a, b))
    slope = p[ALONG]
    if abs(slope) > 1e-9:
        ends = (least - p[HEIGHT]) / slope
        if slope > 0.0:
            low = max(low, ends)
        else:
            high = min(high, ends)
    elif p[HEIGHT] < least:
        return 0.0, 0.0
    return (low, high) if high > low else (0.0, 0.0)


@numba.njit(cache=True, error_model="numpy")
def runs_out(p: Floats, side: float, half_x: float, half_y: float) -> bool:
    """Whether the plateau's plane reaches zero under a corner of the pad that the material covers."""
    ca, sa = np.cos(p[0]), np.sin(p[0])
    for x in (-half_x, half_x):
        for y in (-half_y, half_y):
            t = side * (ca * y - sa * x - p[OFFSET])
            if t > 0.0 and p[HEIGHT] + p[RISE] * t + p[ALONG] * (ca * x + sa * y) < 0.0:
                return True
    return False
