"""Gauss-Newton on the closed form of an outline: lines, discs and the face's plane at once.

Levenberg's damping; the covariance is the inverse of the weighted normal matrix.  The slope of the face has a
weak prior: a pad tilted by more would stand on its housing, and a face smaller than the blur does not show its
slope.
"""

from dataclasses import dataclass
from math import sqrt

import numba
import numpy as np
from numpy.typing import ArrayLike

from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.arc import LONGEST
from exploration.sensing.lines.region import Region
from exploration.sensing.lines.region_model import evaluate
from exploration.sensing.response import Response
from exploration.sensing.surfaces.lone_noise import greatest_block
from exploration.sensing.surfaces.normal_equations import expect, gather, invert
from primitives.arrays import Floats

SLOPE = 0.1  # [rad] standard deviation of the prior
LEVEL = 0.05  # [rad] the same of a pad that was leveled
STEPS = 25
HOPE = 5.0  # times what a step promises, that all further steps together may gain, once
TRIED = 2  # steps are taken
GAINED = 0.02  # [chi2] a step that gains less is the last
LEAST_RADIUS = 0.2  # [mm]
TURN = 0.7  # [rad] of a line in one step


@dataclass(frozen=True)
class RegionFit:
    """The best numbers of one outline for one frame."""

    region: Region
    parameters: Floats  # (region.unknowns,)
    covariance: Floats
    chi2: float  # Huber's
    dof: int
    converged: bool
    structure: float  # [sigma] the largest mean residual of 3 x 3 taxels; about 3 where all is explained

    @property
    def inflation(self) -> float:
        """By how much the misfit widens the covariance."""
        return max(1.0, self.chi2 / max(1, self.dof))

    def settled(self, deviations: float, structure: float) -> bool:
        """Whether chi2 and the residuals' pattern are what noise makes."""
        usual = self.chi2 < self.dof + deviations * sqrt(2 * max(1, self.dof))
        return self.converged and usual and self.structure < structure


def fit_region(
    image: TactileImage,
    response: Response,
    region: Region,
    shape: ArrayLike,
    steps: int = STEPS,
    limit: float = np.inf,
    slope: float = SLOPE,
) -> RegionFit:
    """Fit from `shape` (unknowns - 3,), the lines' and discs' numbers; the plane needs no start.

    Without steps, only the plane is fitted, and chi2 is what that makes of it.  A fit is given up, unconverged,
    once its steps promise too little for chi2 to come below `limit`.  `slope` [rad] is what is expected of it.
    """
    parameters, covariance, chi2, count, converged, structure = _fit(
        image.depth,
        image.sigma,
        image.array.x,
        image.array.y,
        response.variance,
        np.asarray(shape, dtype=np.float64),
        *region.arrays,
        steps,
        limit,
        slope,
    )
    return RegionFit(region, parameters, covariance, chi2, count - len(parameters), converged, structure)


def unexplained(image: TactileImage, response: Response, fit: RegionFit) -> Floats:
    """(rows, columns) [mm] measured less fitted; 0 where dead."""
    array = image.array
    model = np.empty((1 + len(fit.parameters), *array.shape))
    evaluate(array.x, array.y, response.variance, fit.parameters, *fit.region.arrays, model)
    return np.where(np.isfinite(image.sigma), image.depth - model[0], 0.0)


@numba.njit(cache=True, error_model="numpy")
def _weighed(
    depth: Floats,
    sigma: Floats,
    p: Floats,
    slope: float,
    model: Floats,
    normal: Floats,
    rhs: Floats,
    residual: Floats,
) -> tuple[float, int]:
    """Normal equations of the taxels and of what is expected of the slope."""
    chi2, count = gather(depth, sigma, model, normal, rhs, residual)
    for a in range(1, 3):
        chi2 += expect(p[a], slope, a, normal, rhs)
    return chi2, count


@numba.njit(cache=True, error_model="numpy")
def _fit(
    depth: Floats,
    sigma: Floats,
    x: Floats,
    y: Floats,
    variance: Floats,
    shape: Floats,
    sides: Floats,
    terms: Floats,
    signs: Floats,
    steps: int,
    limit: float,
    slope: float,
) -> tuple[Floats, Floats, float, int, bool, float]:
    m = 3 + len(shape)
    discs = 3 + 2 * len(sides)
    size = abs(x[-1] - x[0]) + abs(y[-1] - y[0]) + 6.0 * np.sqrt(variance.max())
    p = np.zeros(m)
    p[3:] = shape
    model = np.zeros((1 + m, len(y), len(x)))
    normal, rhs, residual = np.zeros((m, m)), np.zeros(m), np.zeros(depth.shape)
    new_normal, new_rhs = np.zeros((m, m)), np.zeros(m)
    covariance = np.zeros((m, m))
    evaluate(x, y, variance, p, sides, terms, signs, model)
    chi2, count = _weighed(depth, sigma, p, slope, model, normal, rhs, residual)
    ok, inverse = invert(normal[:3, :3].copy())
    if not ok:
        return p, covariance, chi2, count, False, np.inf
    p[:3] += inverse @ rhs[:3]
    if steps == 0:
        return p, covariance, chi2 - rhs[:3] @ inverse @ rhs[:3], count, False, np.inf
    evaluate(x, y, variance, p, sides, terms, signs, model)
    chi2, count = _weighed(depth, sigma, p, slope, model, normal, rhs, residual)
    damping = 1e-3
    converged = False
    current = True
    for taken in range(steps):
        damped = normal.copy()
        for a in range(m):
            damped[a, a] *= 1.0 + damping
        ok, inverse = invert(damped)
        if not ok:
            damping = max(1e-3, damping * 10.0)
            if damping > 1e6:
                break
            continue
        step = inverse @ rhs
        if taken >= TRIED and damping < 1.0 and chi2 - HOPE * np.dot(step, rhs) > limit:
            break
        trial = p + step
        possible = True
        for k in range(3, discs, 2):
            possible = possible and abs(step[k]) < TURN and abs(trial[k + 1]) < size
        for k in range(discs + 2, m, 3):
            trial[k] = max(trial[k], 0.5 * p[k], LEAST_RADIUS)
            possible = possible and trial[k] < LONGEST
        if not possible:
            damping = max(1e-1, damping * 10.0)
            if damping > 1e6:
                break
            continue
        evaluate(x, y, variance, trial, sides, terms, signs, model)
        new, count = _weighed(depth, sigma, trial, slope, model, new_normal, new_rhs, residual)
        current = new < chi2
        if current:
            gained = chi2 - new
            p = trial
            chi2 = new
            normal[:] = new_normal
            rhs[:] = new_rhs
            damping = damping * 0.1 if damping > 1e-6 else 0.0
            if gained < GAINED:
                converged = True
                break
        else:
            if np.dot(step, rhs) < GAINED:
                converged = True
                break
            damping = max(1e-3, damping * 10.0)
            if damping > 1e8:
                break
    ok, covariance = invert(normal)
    for k in range(3, discs, 2):
        ok = ok and covariance[k, k] < TURN * TURN  # else it has left the pad
    if not current:
        evaluate(x, y, variance, p, sides, terms, signs, model)
        _weighed(depth, sigma, p, slope, model, new_normal, new_rhs, residual)
    return p, covariance, chi2, count, converged and ok, greatest_block(residual, sigma)
