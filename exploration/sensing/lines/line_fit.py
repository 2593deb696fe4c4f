"""Gauss-Newton polish of one line on the sensor model.

The model is a half-plane times a sloped plateau, blurred and taxel-integrated.  With t the distance into the
material, v the coordinate along the line, w the response's width across it and (edge, ramp, line) its tables,

    depth(p) = (A + c v) edge(t/w) + b w ramp(t/w),

so that a plateau that rises away from the edge (b) or along it (c), because the pad or the face is tilted,
does not move the line.  Unknowns are angle, offset, A, b, c; the covariance is the inverse of the weighted
normal matrix.  Residuals beyond `HUBER` sigma weigh less, for taxels that died without telling.

The same with every response integrated once (`order` 1) is the rim of a smooth surface that runs out without
a step, depth = (A + c v) w ramp(t/w) + b w^2 bend(t/w): the cheap alternative that an edge must beat.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numba
import numpy as np
from scipy.special import ndtr

from exploration.sensing.frame import TactileImage, TaxelArray
from exploration.sensing.response import Response, look_up
from exploration.sensing.surfaces.normal_equations import HUBER, invert
from primitives.arrays import Floats, frozen

ENOUGH_SKIN = 2.8  # [blurs] past the outer taxels, for the skin to count as endless
STEPS = 12
DONE = 0.1  # [sigma] steps of angle and offset smaller than this end the iteration


@dataclass(frozen=True)
class LineFit:
    """The polished unknowns of one line."""

    parameters: Floats  # (5,) angle [rad], offset [mm], A [mm], b, c
    covariance: Floats  # (5, 5)
    chi2: float  # Huber's
    dof: int
    converged: bool


def softened(image: TactileImage) -> TactileImage:
    """The image with the taxels whose blur the end of the skin cuts off trusted less.

    The response here is that of an endless skin.  Where the skin ends, what spreads beyond comes back to the outer
    taxels; that share, times the deepest taxel, is added to their sigma.
    """
    if image.margin > ENOUGH_SKIN * image.spread:
        return image
    sigma = _trusted_less(image.sigma, image.depth, _lost(image.array, image.spread, image.margin))
    sigma.flags.writeable = False
    return replace(image, sigma=sigma)


@numba.njit(cache=True, error_model="numpy")
def _trusted_less(sigma: Floats, depth: Floats, lost: Floats) -> Floats:
    deepest = depth.max()
    out = np.empty(sigma.shape)
    for i in range(sigma.shape[0]):
        for j in range(sigma.shape[1]):
            out[i, j] = np.sqrt(sigma[i, j] ** 2 + (lost[i, j] * deepest) ** 2)
    return out


@lru_cache(maxsize=32)
def _lost(array: TaxelArray, spread: float, margin: float) -> Floats:
    """(rows, columns) share of a taxel's blur that the skin's ends cut off."""
    (rows, columns), (px, py) = array.shape, array.pitch
    by_row, by_column = _lost_along(rows, py, spread, margin), _lost_along(columns, px, spread, margin)
    return frozen(by_row[:, None] + by_column)


def _lost_along(count: int, pitch: float, spread: float, margin: float) -> Floats:
    x = (np.arange(count) - (count - 1) / 2) * pitch
    width = np.hypot(spread, pitch / np.sqrt(12.0)) + 1e-9
    end = count * pitch / 2 + margin
    out: Floats = ndtr((x - end) / width) + ndtr((-x - end) / width)
    return out


def fit_line(
    image: TactileImage, response: Response, angle: float, offset: float, side: int, order: int = 0
) -> LineFit:
    """Polish a line that is known to about a response width and 15 degrees."""
    px, py = image.array.pitch
    parameters, covariance, chi2, count, converged = _fit(
        image.depth, image.sigma, px, py, response.table, response.variance, angle, offset, float(side), order
    )
    return LineFit(parameters, covariance, chi2, count - 5, converged)


@numba.njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def _accumulate(
    depth: Floats,
    sigma: Floats,
    px: float,
    py: float,
    table: Floats,
    variance: Floats,
    p: Floats,
    side: float,
    order: int,
    normal: Floats,
    rhs: Floats,
) -> tuple[float, int]:
    rows, columns = depth.shape
    normal[:] = 0.0
    rhs[:] = 0.0
    ca, sa = np.cos(p[0]), np.sin(p[0])
    offset, height, rise, along = p[1], p[2], p[3], p[4]
    width = np.sqrt(variance[0] * sa * sa + variance[1] * ca * ca)
    first = width if order == 1 else 1.0
    chi2 = 0.0
    count = 0
    j5 = np.empty(5)
    for i in range(rows):
        y = (i - (rows - 1) / 2) * py
        for j in range(columns):
            if sigma[i, j] == np.inf:
                continue
            x = (j - (columns - 1) / 2) * px
            across = -sa * x + ca * y
            v = ca * x + sa * y
            change, step, slant = look_up(table, side * (across - offset) / width, order)
            change, step, slant = change * first / width, step * first, slant * first * width
            r = (depth[i, j] - (height + along * v) * step - rise * slant) / sigma[i, j]
            count += 1
            weight = 1.0 / sigma[i, j]
            size = abs(r)
            if size > HUBER:
                chi2 += HUBER * (2.0 * size - HUBER)
                share = np.sqrt(HUBER / size)
                weight *= share
                r *= share
            else:
                chi2 += r * r
            if step == 0.0:
                continue
            slope = (height + along * v) * change + rise * step
            j5[0] = (-side * v * slope + along * across * step) * weight
            j5[1] = -side * slope * weight
            j5[2] = step * weight
            j5[3] = slant * weight
            j5[4] = v * step * weight
            for a in range(5):
                rhs[a] += j5[a] * r
                for b in range(a + 1):
                    normal[a, b] += j5[a] * j5[b]
    for a in range(5):
        for b in range(a):
            normal[b, a] = normal[a, b]
    return chi2, count


@numba.njit(cache=True, error_model="numpy")
def _fit(
    depth: Floats,
    sigma: Floats,
    px: float,
    py: float,
    table: Floats,
    variance: Floats,
    angle: float,
    offset: float,
    side: float,
    order: int,
) -> tuple[Floats, Floats, float, int, bool]:
    normal = np.zeros((5, 5))
    rhs = np.zeros(5)
    p = np.array([angle, offset, 0.0, 0.0, 0.0])
    chi2, count = _accumulate(depth, sigma, px, py, table, variance, p, side, order, normal, rhs)
    covariance = np.zeros((5, 5))
    free = np.zeros((3, 3))
    free[:] = normal[2:, 2:]
    ok, inverse = invert(free)
    if not ok:
        return p, covariance, chi2, count, False
    p[2:] += inverse @ rhs[2:]
    chi2, count = _accumulate(depth, sigma, px, py, table, variance, p, side, order, normal, rhs)
    converged = False
    damping = 0.0
    for _ in range(STEPS):
        damped = normal.copy()
        for a in range(5):
            damped[a, a] *= 1.0 + damping
        ok, inverse = invert(damped)
        if not ok:
            break
        step = inverse @ rhs
        trial = p + step
        new, count = _accumulate(depth, sigma, px, py, table, variance, trial, side, order, normal, rhs)
        if not new < chi2 + 1e-9:
            damping = max(1e-2, damping * 10.0)
            _accumulate(depth, sigma, px, py, table, variance, p, side, order, normal, rhs)
            if damping > 1e4:
                break
            continue
        p = trial
        small = step[0] ** 2 < DONE**2 * inverse[0, 0] and step[1] ** 2 < DONE**2 * inverse[1, 1]
        gained = chi2 - new
        chi2 = new
        damping *= 0.1
        if damping < 1e-3:
            damping = 0.0
        if small or (gained < 0.01 and damping == 0.0):
            converged = True
            break
    ok, covariance = invert(normal)
    return p, covariance, chi2, count, converged and ok
