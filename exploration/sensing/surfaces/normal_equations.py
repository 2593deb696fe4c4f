"""Small symmetric positive definite systems inside kernels: Cholesky, without LAPACK's call overhead."""

import numba
import numpy as np

from primitives.arrays import Floats


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
