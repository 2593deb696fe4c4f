"""The Gaussian blur of a wedge: the chance that two correlated normal variables are both below h and k.

With unit normals m1, m2 and t_i the distance into half-plane i in widths of the blur, the blurred indicator of
the wedge between them is Phi2(t1, t2; c), c = m1 . m2 (in blur units).  For |c| < `OPEN` it is integrated over
the correlation (Plackett),

    Phi2 = Phi(h) Phi(k) + 1/(2 pi) int_0^asin(c) exp(-(h^2 + k^2 - 2 h k sin x) / (2 cos^2 x)) dx,

otherwise by Owen's function T, Phi2 = (Phi(h) + Phi(k))/2 - T(h, (k - c h)/(h s)) - T(k, (h - c k)/(k s)) - delta,
s = sqrt(1 - c^2), delta = 1/2 where h and k differ in sign.  Gauss-Legendre, right to 1e-6.
"""

from math import atan, erfc, exp, pi, sin, sqrt

import numba
import numpy as np

from primitives.arrays import frozen

FAR = 6.0  # [widths] beyond this a half-plane is all or nothing
OPEN = 0.6
NODES = 6
_ALMOST = 1.0 - 1e-12
_NODES, _WEIGHTS = (frozen(v) for v in np.polynomial.legendre.leggauss(NODES))


@numba.njit(cache=True, error_model="numpy", inline="always")
def density(t: float) -> float:
    """The standard normal density."""
    return 0.3989422804014327 * exp(-0.5 * t * t)


@numba.njit(cache=True, error_model="numpy")
def chance(t: float) -> float:
    """The standard normal distribution."""
    return 0.5 * erfc(-0.7071067811865476 * t)


@numba.njit(cache=True, error_model="numpy")
def _owen(h: float, a: float) -> float:
    """Owen's T for h >= 0."""
    size = abs(a)
    if h > FAR:
        return 0.0
    if size > 1.0:
        k = size * h
        ph, pk = chance(h), chance(k)
        value = 0.5 * (ph + pk) - ph * pk - _owen_inner(k, 1.0 / size)
    else:
        value = _owen_inner(h, size)
    return float(value) if a >= 0.0 else -float(value)


@numba.njit(cache=True, error_model="numpy")
def _owen_inner(h: float, a: float) -> float:
    if h > FAR:
        return 0.0
    end = min(a, FAR / max(h, 1e-9)) if h > 0.0 else a
    total = 0.0
    for i in range(NODES):
        x = 0.5 * end * (_NODES[i] + 1.0)
        q = 1.0 + x * x
        total += _WEIGHTS[i] * exp(-0.5 * h * h * q) / q
    return float(0.25 * end * total / pi)


@numba.njit(cache=True, error_model="numpy")
def both(h: float, k: float, c: float) -> float:
    """P(X < h, Y < k) for standard normals of correlation c."""
    if h < -FAR or k < -FAR:
        return 0.0
    if h > FAR:
        return float(chance(k))
    if k > FAR:
        return float(chance(h))
    if c > _ALMOST:
        return float(chance(min(h, k)))
    if c < -_ALMOST:
        return float(max(0.0, chance(h) + chance(k) - 1.0))
    if abs(c) < OPEN:
        half = 0.5 * atan(c / sqrt(1.0 - c * c))
        total = 0.0
        for i in range(NODES):
            s = sin(half * (_NODES[i] + 1.0))
            total += _WEIGHTS[i] * exp(-0.5 * (h * h + k * k - 2.0 * h * k * s) / (1.0 - s * s))
        return float(chance(h) * chance(k) + 0.5 * half * total / pi)
    s = sqrt(1.0 - c * c)
    if abs(h) < 1e-9:
        h = 1e-9
    if abs(k) < 1e-9:
        k = 1e-9
    value = 0.5 * (chance(h) + chance(k)) - (0.0 if h * k > 0.0 else 0.5)
    value -= _owen(abs(h), (k - c * h) / (h * s)) + _owen(abs(k), (h - c * k) / (k * s))
    return float(value)
