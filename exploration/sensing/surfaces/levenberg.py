"""Levenberg's steps on the normal equations that a kernel gathers, and what else of a fit those equations tell.

The loop is no kernel itself: one that is handed another is compiled anew in every process, and a step costs less
than the equations that it is taken on.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from exploration.sensing.surfaces.footprint import HOPE, Footprint
from exploration.sensing.surfaces.normal_equations import invert
from primitives.arrays import Floats

STEPS = 40
GAINED = 0.02  # [chi2] a step that gains less is the last


class Equations(NamedTuple):
    """Of a model at some parameters (n,)."""

    chi2: float
    taxels: int  # behind it
    normal: Floats  # (n, n)
    rhs: Floats  # (n,)
    residual: Floats  # (rows, columns) [sigma]


def descended(equations: Callable[[Floats], Equations], start: Floats, limit: float = np.inf) -> Footprint:
    """The least chi2 from `start` (n,).

    Given up, unconverged, once steps promise too little for it to come below `limit`.
    """
    p, at = start, equations(start)
    damping, converged = 1e-3, False
    for _ in range(STEPS):
        ok, inverse = invert(at.normal + damping * np.diag(np.diag(at.normal)))
        if not ok:
            damping = max(1e-3, damping * 10.0)
            if damping > 1e6:
                break
            continue
        step = inverse @ at.rhs
        promised = float(step @ at.rhs)
        if damping < 1.0 and at.chi2 - HOPE * promised > limit:
            break
        tried = equations(p + step)
        if tried.chi2 < at.chi2:
            converged = at.chi2 - tried.chi2 < GAINED
            p, at = p + step, tried
            damping *= 0.1
        else:
            converged = promised < GAINED
            damping = max(1e-3, damping * 10.0)
        if converged or damping > 1e8:
            break
    ok, covariance = invert(at.normal)
    return Footprint(p, covariance, at.chi2, at.taxels - len(p), converged and ok, at.residual)


def carried(fit: Footprint, onto: Callable[[Floats], Floats], moved: Sequence[float]) -> Footprint:
    """The fit in the parameters that (n,) of its own stand for; `moved` (n,) by how much, for derivatives."""
    n = len(moved)
    p = fit.parameters[:n]
    steps = np.diag(moved)
    turn = np.column_stack([(onto(p + step) - onto(p - step)) / (2.0 * step.sum()) for step in steps])
    covariance = turn @ fit.covariance[:n, :n] @ turn.T
    return Footprint(onto(p), covariance, fit.chi2, fit.dof, fit.converged, fit.residual)
