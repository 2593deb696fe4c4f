"""Least squares inside kernels: a frame's normal equations, and their inverse without LAPACK's call overhead.

Residuals beyond `HUBER` sigma weigh less, for taxels that died without telling.
"""

import numba
import numpy as np

from primitives.arrays import Floats

HUBER = 3.0  # [sigma]


@numba.njit(cache=True)
def invert(matrix: Floats) -> tuple[bool, Floats]:
    """Whether an (n, n) normal matrix is positive definite, and its inverse.

    The matrix is first scaled to unit diagonal, so parameters of any unit may stand beside each other.
    """
    n = len(matrix)
    inverse = np.zeros((n, n))
    scale = np.empty(n)
    for i in range(n):
        if not matrix[i, i] > 0.0:
            return False, inverse
        scale[i] = 1.0 / np.sqrt(matrix[i, i])
    lower = np.zeros((n, n))
    for i in range(n):
        for j in range(i + 1):
            s = matrix[i, j] * scale[i] * scale[j]
            for k in range(j):
                s -= lower[i, k] * lower[j, k]
            if i == j:
                if not s > 1e-12:
                    return False, inverse
                lower[i, i] = np.sqrt(s)
            else:
                lower[i, j] = s / lower[j, j]
    root = np.zeros((n, n))
    for j in range(n):
        root[j, j] = 1.0 / lower[j, j]
        for i in range(j + 1, n):
            s = 0.0
            for k in range(j, i):
                s -= lower[i, k] * root[k, j]
            root[i, j] = s / lower[i, i]
    for i in range(n):
        for j in range(i + 1):
            s = 0.0
            for k in range(i, n):
                s += root[k, i] * root[k, j]
            inverse[i, j] = s * scale[i] * scale[j]
            inverse[j, i] = inverse[i, j]
    return True, inverse


@numba.njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def gather(
    depth: Floats, sigma: Floats, model: Floats, normal: Floats, rhs: Floats, residual: Floats
) -> tuple[float, int]:
    """Huber's chi2 and the taxels behind it, of a model (1 + m, rows, columns) of depth and its m derivatives.

    Fills (m, m) `normal`, (m,) `rhs` and (rows, columns) `residual` [sigma], which is 0 where dead.
    """
    m = len(rhs)
    normal[:] = 0.0
    rhs[:] = 0.0
    chi2 = 0.0
    count = 0
    jacobian = np.empty(m)
    for i in range(depth.shape[0]):
        for j in range(depth.shape[1]):
            residual[i, j] = 0.0
            if sigma[i, j] == np.inf:
                continue
            scale = 1.0 / sigma[i, j]
            r = (depth[i, j] - model[0, i, j]) * scale
            residual[i, j] = r
            count += 1
            size = abs(r)
            weight = 1.0
            if size > HUBER:
                chi2 += HUBER * (2.0 * size - HUBER)
                weight = HUBER / size
            else:
                chi2 += r * r
            for a in range(m):
                jacobian[a] = model[1 + a, i, j] * scale
            for a in range(m):
                weighted = jacobian[a] * weight
                rhs[a] += weighted * r
                for b in range(a + 1):
                    normal[a, b] += weighted * jacobian[b]
    for a in range(m):
        for b in range(a):
            normal[b, a] = normal[a, b]
    return chi2, count


@numba.njit(cache=True)
def expect(value: float, sigma: float, at: int, normal: Floats, rhs: Floats) -> float:
    """Add one more reading, of the unknown `at`: that it is 0 within `sigma`; its chi2."""
    rhs[at] -= value / sigma**2
    normal[at, at] += 1.0 / sigma**2
    return (value / sigma) ** 2
