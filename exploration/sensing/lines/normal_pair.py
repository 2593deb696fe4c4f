"""The Gaussian blur of a wedge: the chance that two correlated normal variables are both below h and k.

With unit normals m1, m2 and t_i the distance into half-plane i in widths of the blur, the blurred indicator of
the wedge between them is Phi2(t1, t2; c), c = m1 . m2 (in blur units).  For |c| < `OPEN` it is integrated over
the correlation (Plackett),

    Phi2 = Phi(h) Phi(k) + 1/(2 pi) int_0^asin(c) exp(-(h^2 + k^2 - 2 h k sin x) / (2 cos^2 x)) dx,

whose nodes are the same for all taxels; otherwise by Owen's function T, with s = sqrt(1 - c^2),

    Phi2 = (Phi(h) + Phi(k))/2 - T(h, (k - c h)/(h s)) - T(k, (h - c k)/(k s)) - delta,

delta = 1/2 where h and k differ in sign.  Gauss-Legendre, right to 1e-6.
"""

from math import asin, exp, pi, sin, sqrt

import numba
import numpy as np
from scipy.special import ndtr

from primitives.arrays import Floats, frozen

FAR = 5.0  # [widths] beyond this a half-plane is all or nothing
OPEN = 0.75
NODES, OWEN_NODES = 4, 6
_ALMOST = 1.0 - 1e-12
_PER_UNIT = 200.0
_CHANCE = frozen(ndtr(np.arange(-FAR * _PER_UNIT, FAR * _PER_UNIT + 2) / _PER_UNIT))
_AT, _WEIGHT = (frozen(v) for v in np.polynomial.legendre.leggauss(NODES))
_OWEN_AT, _OWEN_WEIGHT = (frozen(v) for v in np.polynomial.legendre.leggauss(OWEN_NODES))


@numba.njit(cache=True, error_model="numpy", inline="always")
def density(t: float) -> float:
    """The standard normal density."""
    return 0.3989422804014327 * exp(-0.5 * t * t)


@numba.njit(cache=True, error_model="numpy", inline="always")
def chance(t: float) -> float:
    """The standard normal distribution, all or nothing beyond `FAR`; from a table, right to 1e-6."""
    if t <= -FAR:
        return 0.0
    if t >= FAR:
        return 1.0
    place = (t + FAR) * _PER_UNIT
    i = int(place)
    low = _CHANCE[i]
    return float(low + (place - i) * (_CHANCE[i + 1] - low))


@numba.njit(cache=True, error_model="numpy")
def prepare(c: float, nodes: Floats) -> None:
    """Fill `nodes` (NODES, 3) for `both` at one correlation: weight, sine, and 1 / (2 cos^2)."""
    if abs(c) >= OPEN:
        return
    half = 0.5 * asin(c)
    for i in range(NODES):
        s = sin(half * (_AT[i] + 1.0))
        nodes[i, 0] = 0.5 * half * _WEIGHT[i] / pi
        nodes[i, 1] = s
        nodes[i, 2] = 0.5 / (1.0 - s * s)


@numba.njit(cache=True, error_model="numpy")
def both(h: float, k: float, ph: float, pk: float, c: float, nodes: Floats) -> float:
    """P(X < h, Y < k) for standard normals of correlation c, ph and pk being their chances by themselves."""
    if h < -FAR or k < -FAR:
        return 0.0
    if h > FAR:
        return pk
    if k > FAR:
        return ph
    if abs(c) < OPEN:
        total = ph * pk
        for i in range(NODES):
            total += nodes[i, 0] * exp(-(h * h + k * k - 2.0 * h * k * nodes[i, 1]) * nodes[i, 2])
        return total
    if c > _ALMOST:
        return min(ph, pk)
    if c < -_ALMOST:
        return max(0.0, ph + pk - 1.0)
    s = sqrt(1.0 - c * c)
    if abs(h) < 1e-9:
        h = 1e-9
    if abs(k) < 1e-9:
        k = 1e-9
    value = 0.5 * (ph + pk) - (0.0 if h * k > 0.0 else 0.5)
    value -= _owen(abs(h), (k - c * h) / (h * s)) + _owen(abs(k), (h - c * k) / (k * s))
    return float(value)


@numba.njit(cache=True, error_model="numpy")
def _owen(h: float, a: float) -> float:
    """Owen's T for h >= 0."""
    size = abs(a)
    if h > FAR:
        return 0.0
    if size > 1.0:
        k = size * h
        ph = chance(h)
        pk = chance(k) if k < FAR else 1.0
        value = 0.5 * (ph + pk) - ph * pk - _owen_inner(k, 1.0 / size)
    else:
        value = _owen_inner(h, size)
    return float(value) if a >= 0.0 else -float(value)


@numba.njit(cache=True, error_model="numpy")
def _owen_inner(h: float, a: float) -> float:
    if h > FAR:
        return 0.0
    total = 0.0
    for i in range(OWEN_NODES):
        x = 0.5 * a * (_OWEN_AT[i] + 1.0)
        q = 1.0 + x * x
        total += _OWEN_WEIGHT[i] * exp(-0.5 * h * h * q) / q
    return float(0.25 * a * total / pi)
