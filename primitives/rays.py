"""Real roots of the polynomials that rays make with surfaces, vectorized, inf where there is none.

Quadratics by the form without cancellation, t1 = q / a, t2 = c / q (Numerical Recipes, section 5.6);
quartics by companion eigenvalues, polished by Newton.
"""

import numpy as np

from primitives.arrays import Floats

_PARALLEL = 1e-14  # leading coefficients below this, of unit directions, are zero
_IMAGINARY = 1e-4  # largest imaginary part of a root that may yet be a real double root
_RESIDUAL = 1e-9  # largest value of the monic quartic at a polished root, relative to its terms


def linear_roots(slope: Floats, value: Floats) -> Floats:
    """(n, 1) t with slope t + value = 0."""
    flat = np.abs(slope) < _PARALLEL
    return np.where(flat, np.inf, -value / np.where(flat, 1.0, slope))[:, None]


def quadratic_roots(a: Floats, b: Floats, c: Floats) -> Floats:
    """(n, 2) t with a t^2 + 2 b t + c = 0; nearly linear ones too."""
    discriminant = b * b - a * c
    real = discriminant >= 0
    q = -(b + np.copysign(np.sqrt(np.where(real, discriminant, 0.0)), b))
    no_a, no_q = np.abs(a) < _PARALLEL, np.abs(q) == 0
    first = np.where(real & ~no_a, q / np.where(no_a, 1.0, a), np.inf)
    second = np.where(real & ~no_q, c / np.where(no_q, 1.0, q), np.inf)
    return np.stack([first, second], axis=1)


def quartic_roots(coefficients: Floats) -> Floats:
    """(n, 4) t with t^4 + c0 t^3 + c1 t^2 + c2 t + c3 = 0, for roots of order one."""
    n = len(coefficients)
    companion = np.zeros((n, 4, 4))
    companion[:, 0] = -coefficients
    companion[:, [1, 2, 3], [0, 1, 2]] = 1.0
    found = np.linalg.eigvals(companion)
    t = np.where(np.abs(found.imag) < _IMAGINARY, found.real, np.nan)
    c = coefficients[:, :, None]
    for _ in range(4):
        value = (((t + c[:, 0]) * t + c[:, 1]) * t + c[:, 2]) * t + c[:, 3]
        slope = ((4 * t + 3 * c[:, 0]) * t + 2 * c[:, 1]) * t + c[:, 2]
        t = t - np.where(np.abs(slope) > _PARALLEL, value / np.where(slope == 0, 1.0, slope), 0.0)
    size = 1.0 + np.abs(t) ** 4 + np.abs(coefficients).max(axis=1)[:, None]
    value = (((t + c[:, 0]) * t + c[:, 1]) * t + c[:, 2]) * t + c[:, 3]
    return np.where(np.abs(value) < _RESIDUAL * size, t, np.inf)
