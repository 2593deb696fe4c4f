"""The smooth contacts that a frame may be, as one dome with its curvatures held to a shape.

With coefficients p = (d0, gx, gy, kxx, kxy, kyy) and e = (cos a, sin a),

    plane K = 0,    ridge K = k e e^T,    ball K = k I,    dome K free;

`tangents` is T = dp/du for a shape's own unknowns u, and `moved` takes a step in them.
"""

import numba
import numpy as np

from exploration.sensing.surfaces.normal_equations import invert
from primitives.arrays import Floats

DOME, PLANE, RIDGE, BALL = 0, 1, 2, 3
UNKNOWNS = (6, 3, 5, 4)  # of each


@numba.njit(cache=True, error_model="numpy")
def nearest(p: Floats, covariance: Floats, shape: int) -> Floats:
    """The coefficients of a shape nearest to (6,) `p` in its covariance: exact but for a ridge's angle."""
    k = np.zeros(3)
    ray = np.zeros(3)
    if shape == RIDGE:
        sign = 1.0 if p[3] + p[5] >= 0.0 else -1.0
        angle = 0.5 * np.arctan2(sign * p[4], sign * 0.5 * (p[3] - p[5]))
        c, s = np.cos(angle), np.sin(angle)
        ray[:] = (c * c, c * s, s * s)
    elif shape == BALL:
        ray[:] = (1.0, 0.0, 1.0)
    out = p.copy()
    if shape == DOME:
        return out
    ok, precision = invert(np.ascontiguousarray(covariance[3:, 3:]))
    if ok:
        weight = precision @ ray
        size = ray @ weight
        if size > 0.0:
            k = ray * ((p[3:] @ weight) / size)
        out[:3] -= np.ascontiguousarray(covariance[:3, 3:]) @ (precision @ (p[3:] - k))
    out[3:] = k
    return out


@numba.njit(cache=True, error_model="numpy")
def tangents(p: Floats, shape: int) -> Floats:
    """(6, unknowns): how the coefficients move with the shape's own unknowns."""
    out = np.zeros((6, UNKNOWNS[shape]))
    for a in range(3):
        out[a, a] = 1.0
    if shape == DOME:
        for a in range(3, 6):
            out[a, a] = 1.0
    elif shape == BALL:
        out[3, 3] = out[5, 3] = 1.0
    elif shape == RIDGE:
        k = p[3] + p[5]
        sign = 1.0 if k >= 0.0 else -1.0
        angle = 0.5 * np.arctan2(sign * p[4], sign * 0.5 * (p[3] - p[5]))
        c, s = np.cos(angle), np.sin(angle)
        out[3, 3], out[4, 3], out[5, 3] = c * c, c * s, s * s
        out[3, 4], out[4, 4], out[5, 4] = -2.0 * k * c * s, k * (c * c - s * s), 2.0 * k * c * s
    return out


@numba.njit(cache=True, error_model="numpy")
def moved(p: Floats, step: Floats, shape: int) -> Floats:
    """The coefficients after a step in the shape's own unknowns."""
    out = p.copy()
    out[:3] += step[:3]
    if shape == DOME:
        out[3:] += step[3:]
    elif shape == BALL:
        out[3] += step[3]
        out[5] += step[3]
    elif shape == RIDGE:
        k = p[3] + p[5]
        sign = 1.0 if k >= 0.0 else -1.0
        angle = 0.5 * np.arctan2(sign * p[4], sign * 0.5 * (p[3] - p[5])) + step[4]
        c, s = np.cos(angle), np.sin(angle)
        k += step[3]
        out[3], out[4], out[5] = k * c * c, k * c * s, k * s * s
    return out
