"""Compiled: the pose that lays a pair of contacts on a pair of surface points."""

import numpy as np
from numba import njit


@njit(cache=True, nogil=True, inline="always")
def dot(a, b):  # type: ignore[no-untyped-def]
    """Of two (3,) vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, nogil=True)
def frame(u, na, nb, out):  # type: ignore[no-untyped-def]
    """Columns: the line, the part across it of both normals' sum, or of their difference if that is longer."""
    along_a, along_b = dot(na, u), dot(nb, u)
    plus, minus = 0.0, 0.0
    for k in range(3):
        x, y = na[k] - along_a * u[k], nb[k] - along_b * u[k]
        out[k, 1], out[k, 2] = x + y, x - y
        plus += (x + y) * (x + y)
        minus += (x - y) * (x - y)
    if max(plus, minus) < 1e-6:
        turned(u, 0.0, out)
        return
    column, scale = (1, np.sqrt(plus)) if plus >= 0.05 * minus else (2, np.sqrt(minus))
    for k in range(3):
        out[k, 0], out[k, 1] = u[k], out[k, column] / scale
    _across(out)


@njit(cache=True, nogil=True)
def turned(u, angle, out):  # type: ignore[no-untyped-def]
    """Columns: the line, and two across it, turned about it."""
    least = 0
    for axis in range(1, 3):
        if abs(u[axis]) < abs(u[least]):
            least = axis
    scale = np.sqrt(max(1.0 - u[least] * u[least], 1e-12))
    for k in range(3):
        out[k, 0] = u[k]
        out[k, 1] = ((1.0 if k == least else 0.0) - u[least] * u[k]) / scale
    _across(out)
    c, s = np.cos(angle), np.sin(angle)
    for k in range(3):
        e, f = out[k, 1], out[k, 2]
        out[k, 1], out[k, 2] = c * e + s * f, c * f - s * e


@njit(cache=True, nogil=True, inline="always")
def _across(out):  # type: ignore[no-untyped-def]
    out[0, 2] = out[1, 0] * out[2, 1] - out[2, 0] * out[1, 1]
    out[1, 2] = out[2, 0] * out[0, 1] - out[0, 0] * out[2, 1]
    out[2, 2] = out[0, 0] * out[1, 1] - out[1, 0] * out[0, 1]


@njit(cache=True, nogil=True)
def put(pose, model, scene, pa, pb, si, sj):  # type: ignore[no-untyped-def]
    """The pose that turns frame `scene` into `model`, the middle of contacts on that of samples."""
    for i in range(3):
        shift = 0.5 * (si[i] + sj[i])
        for j in range(3):
            r = model[i, 0] * scene[j, 0] + model[i, 1] * scene[j, 1] + model[i, 2] * scene[j, 2]
            pose[i, j] = r
            shift -= 0.5 * r * (pa[j] + pb[j])
        pose[i, 3] = shift
