"""By how much the likeliest outline of a frame is off on average, for the model bends within its errors.

With J the model's derivatives, W the taxels' precision and C the covariance, least squares are off by

    E[p - truth] = -C J^T W m / 2,    m_i = tr(C d^2 model_i / dp^2)

to second order (Box 1971, Bias in nonlinear estimation).  With C = L L^T, m is the sum of the model's second
derivatives along L's columns: differences of exact first derivatives.  A boss of R 3 mm is read .04 mm too large
by it, and an arc of curvature within normal errors has the mean of its 1/k (our derivation).
"""

import numba
import numpy as np

from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.region_fit import LEAST_RADIUS, RegionFit
from exploration.sensing.lines.region_model import evaluate
from exploration.sensing.response import Response
from primitives.arrays import Floats

STEP = 0.2  # [standard deviations] of the differences


def bias_of(image: TactileImage, response: Response, fit: RegionFit) -> Floats:
    """(region.unknowns,) what to take off the parameters of a fit; zero where the frame leaves one open."""
    try:
        axes = np.linalg.cholesky(fit.covariance)
    except np.linalg.LinAlgError:
        return np.zeros(len(fit.parameters))
    array = image.array
    toward = _bent(
        array.x, array.y, response.variance, image.sigma, fit.parameters, axes, *fit.region.arrays, STEP
    )
    bias: Floats = -0.5 * fit.covariance @ toward
    return bias if np.isfinite(bias).all() else np.zeros(len(bias))


@numba.njit(cache=True, error_model="numpy")
def _bent(
    x: Floats,
    y: Floats,
    variance: Floats,
    sigma: Floats,
    p: Floats,
    axes: Floats,
    sides: Floats,
    terms: Floats,
    signs: Floats,
    step: float,
) -> Floats:
    """J^T W m."""
    n = len(p)
    bend, model = np.zeros(sigma.shape), np.empty((1 + n, len(y), len(x)))
    for k in range(n):
        for sign in (1.0, -1.0):
            moved = p + sign * step * axes[:, k]
            for at in range(5 + 2 * len(sides), n, 3):
                moved[at] = max(moved[at], LEAST_RADIUS)
            evaluate(x, y, variance, moved, sides, terms, signs, model)
            for a in range(n):
                bend += sign / (2.0 * step) * axes[a, k] * model[1 + a]
    evaluate(x, y, variance, p, sides, terms, signs, model)
    out = np.zeros(n)
    for a in range(n):
        out[a] = np.sum(model[1 + a] * bend / (sigma * sigma))
    return out
