"""How surely a fitted surface lies where it is said to lie.

A step x of the shape's own parameters, of covariance C, moves the surface at a point p outward by J(p) x, so its
standard deviation across itself there is sqrt(J C J').
"""

from __future__ import annotations

import numpy as np

from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.fit import Fit
from primitives.residuals import Problem, linearize


def distance_sigma(fit: Fit, points: Floats) -> Floats:
    """(n,) standard deviation [mm] of a fitted surface across itself at (n, 3) points."""
    _, slope = linearize(fit.shape, Problem.of(Contacts.of(points, sigma=1.0)), 1.0)
    scale = max(1.0, fit.chi2 / max(fit.dof, 1))
    variance: Floats = scale * np.einsum("ni,ij,nj->n", slope, fit.covariance, slope)
    return np.sqrt(np.maximum(variance, 0.0))
