"""The Gaussian blur of a disc (our derivation from the Rice distribution).

In widths of the blur, a disc of radius b is seen from distance a of its center as F(a, b) = P(|X| < b) for X
normal about a.  With I0, I1 the modified Bessel functions and

    g0 = b exp(-(a^2 + b^2)/2) I0(a b),    g1 = b exp(-(a^2 + b^2)/2) I1(a b),

    F_b = g0,  F_a = -g1,  F_ab = b g1 - a g0,  F_aa = a g1 - b g0 + g1/a.

F itself is -g1 integrated from outside, once for each b, by Simpson's rule, and interpolated by cubics whose
slopes are exact.  For a large b it is the straight edge, shifted by half a width over b.
"""

from math import exp, sqrt

import numba
import numpy as np

from primitives.arrays import Floats, frozen

CELLS = 48  # of the radial table
REACH = 6.0  # [widths] either side of the rim
_I0_NEAR = frozen([1.0, 3.5156229, 3.0899424, 1.2067492, 0.2659732, 0.0360768, 0.0045813])
_I1_NEAR = frozen([0.5, 0.87890594, 0.51498869, 0.15084934, 0.02658733, 0.00301532, 0.00032411])
_I0_FAR = frozen(
    [
        0.39894228, 0.01328592, 0.00225319, -0.00157565, 0.00916281,
        -0.02057706, 0.02635537, -0.01647633, 0.00392377,
    ]
)  # fmt: skip
_I1_FAR = frozen(
    [
        0.39894228, -0.03988024, -0.00362018, 0.00163801, -0.01031555,
        0.02282967, -0.02895312, 0.01787654, -0.00420059,
    ]
)  # fmt: skip


@numba.njit(cache=True, error_model="numpy", inline="always")
def _polynomial(coefficients: Floats, y: float) -> float:
    value = 0.0
    for k in range(len(coefficients) - 1, -1, -1):
        value = value * y + coefficients[k]
    return value


@numba.njit(cache=True, error_model="numpy", inline="always")
def _bessel(z: float) -> tuple[float, float]:
    """exp(-z) I0(z) and exp(-z) I1(z) for z >= 0 (Abramowitz and Stegun 9.8.1 to 9.8.4, right to 2e-7)."""
    if z < 3.75:
        y, fade = (z / 3.75) ** 2, exp(-z)
        return _polynomial(_I0_NEAR, y) * fade, _polynomial(_I1_NEAR, y) * z * fade
    y, fade = 3.75 / z, 1.0 / sqrt(z)
    return _polynomial(_I0_FAR, y) * fade, _polynomial(_I1_FAR, y) * fade


@numba.njit(cache=True, error_model="numpy", inline="always")
def rim(a: float, b: float) -> tuple[float, float, float]:
    """g0, g1 and g1/a."""
    i0, i1 = _bessel(a * b)
    fade = b * exp(-0.5 * (a - b) * (a - b))
    g1 = fade * i1
    return fade * i0, g1, (g1 / a if a > 1e-6 else 0.5 * b * fade)


@numba.njit(cache=True, error_model="numpy")
def tabulate(b: float, table: Floats) -> tuple[float, float]:
    """Fill `table` (CELLS + 1, 2) with F and F_a at a = first + i step; first and step."""
    first = max(0.0, b - REACH)
    step = (b + REACH - first) / CELLS
    table[CELLS, 0] = 0.0
    table[CELLS, 1] = -rim(first + CELLS * step, b)[1]
    for i in range(CELLS - 1, -1, -1):
        a = first + i * step
        table[i, 1] = -rim(a, b)[1]
        middle = -rim(a + 0.5 * step, b)[1]
        table[i, 0] = table[i + 1, 0] - step / 6.0 * (table[i, 1] + 4.0 * middle + table[i + 1, 1])
    return first, step


@numba.njit(cache=True, error_model="numpy", inline="always")
def covered(table: Floats, first: float, step: float, a: float) -> float:
    """F at a."""
    place = (a - first) / step
    if place <= 0.0:
        return float(table[0, 0])
    if place >= CELLS:
        return 0.0
    i = int(place)
    f = place - i
    g = 1.0 - f
    value = g * g * (1.0 + 2.0 * f) * table[i, 0] + f * f * (3.0 - 2.0 * f) * table[i + 1, 0]
    return float(value + f * g * step * (g * table[i, 1] - f * table[i + 1, 1]))


def of_disc(a: Floats, b: float) -> Floats:
    """F at each distance."""
    table = np.empty((CELLS + 1, 2))
    first, step = tabulate(b, table)
    return np.array([covered(table, first, step, float(v)) for v in np.ravel(a)]).reshape(np.shape(a))


def slope_of_disc(a: Floats, b: float) -> Floats:
    """F_a at each distance."""
    return np.array([-rim(float(v), b)[1] for v in np.ravel(a)]).reshape(np.shape(a))
