"""Plane, ridge, ball or dome: the order of the surface under the pad, as probabilities from one frame.

A dome fitted to the frame has curvatures H = (kxx + kyy)/2, A = (kxx - kyy)/2, B = kxy with covariance S.  The
evidence for each order is the likelihood of (H, A, B) integrated over what the order allows, every curvature
drawn from N(0, v) before touch (`primitives.curvature`).  A plane is a point; one curvature along a ray r, as a
ball's r = (1, 0, 0) or a ridge's r = (1, cos 2a, sin 2a)/2 at every angle a, gains on it

    log N(y; 0, S + v r r^T) - log N(y; 0, S) = b^2 v / (2 (1 + a v)) - log(1 + a v)/2,

    a = r^T S^-1 r,    b = r^T S^-1 y.

Contact ends where the surface leaves the skin, so far from the dome chi2 is no longer quadratic: every order that
is not out of the question is fitted itself, and what its chi2 differs from the quadratic is taken off (Laplace's
approximation about each order's own best; our derivation).
"""

from dataclasses import dataclass

import numba
import numpy as np

from exploration.sensing.surfaces.footprint import Footprint
from exploration.sensing.surfaces.smooth_fit import SmoothContact, fit_shape
from exploration.sensing.surfaces.smooth_shapes import BALL, DOME, PLANE, RIDGE
from primitives.arrays import Floats, frozen
from primitives.curvature import OrderPrior

SHAPES = (PLANE, RIDGE, BALL, DOME)  # in the order of `primitives.curvature.ORDERS`


PRIOR = OrderPrior(weights=(0.4, 0.335, 0.25, 0.015))  # one face of parts in ninety has two curvatures


@dataclass(frozen=True)
class OrderConfig:
    """How far the fits are believed."""

    prior: OrderPrior = PRIOR
    floor: float = 3e-5  # [1/mm] error of curvature that the model itself makes
    share: float = 0.01  # of the greatest curvature, the same
    open: float = 60.0  # [log] by which an order may lie behind and still be fitted itself
    sure: float = (
        0.5  # share of the curved orders' probability from which a surface takes its order's own fit
    )


DEFAULT = OrderConfig()


@dataclass(frozen=True)
class Ordered:
    """The orders' probabilities, and the fit that tells the surface best."""

    probability: Floats  # (4,) of `primitives.curvature.ORDERS`
    shape: int  # of `fit`
    fit: Footprint
    chi2: float  # of the dome
    evidence: float  # log, of all orders together, on that chi2; the prior of each is in it
    volume: float  # log, of what the frame leaves of depth and slopes

    @property
    def curved(self) -> bool:
        """Whether curvature is needed."""
        return self.shape != PLANE


def order_contact(contact: SmoothContact, dome: Footprint, config: OrderConfig = DEFAULT) -> Ordered:
    """Which order the frame shows; a dome where its curved order is in doubt."""
    inflation = max(1.0, dome.chi2 / max(1, dome.dof))
    logs, quadratic = _evidence(
        dome.parameters, dome.covariance, inflation, config.floor, config.share, *_prior(config)
    )
    fits = [dome, dome, dome, dome]
    covered = bool(contact.mask.all())  # then depth is linear in the coefficients, and chi2 quadratic
    best = float(logs.max())
    plane = float(quadratic[0])
    for order, shape in enumerate(SHAPES[:3]):
        if logs[order] > best - (1.0 if covered else config.open):
            limit = dome.chi2 + inflation * (quadratic[order] + 2.0 * config.open)
            fits[order] = fit_shape(contact, dome, shape, limit)
            logs[order] -= 0.5 * ((fits[order].chi2 - dome.chi2) / inflation - quadratic[order])
    top = float(logs.max())
    probability = np.exp(logs - top)
    evidence = top + float(np.log(probability.sum())) - 0.5 * plane
    probability /= probability.sum()
    curved = probability[1:]
    if probability[0] >= 0.5 and fits[0].converged and fits[0] is not dome:
        choice = 0
    else:
        choice = 1 + int(curved.argmax())
        if curved[choice - 1] < config.sure * curved.sum() or not fits[choice].converged:
            choice = 3
        choice = 3 if fits[choice] is dome else choice
    level = np.linalg.inv(dome.covariance)[:3, :3] / (2 * np.pi)
    volume = -0.5 * float(np.log(np.linalg.det(level)))
    return Ordered(frozen(probability), SHAPES[choice], fits[choice], dome.chi2, evidence, volume)


def _prior(config: OrderConfig) -> tuple[float, tuple[float, float, float, float]]:
    return config.prior.scale**2, config.prior.weights


def order_alone(p: Floats, covariance: Floats, config: OrderConfig = DEFAULT) -> Floats:
    """(4,) probabilities from the (6,) coefficients of a dome and their covariance alone."""
    logs, _ = _evidence(p, covariance, 1.0, config.floor, config.share, *_prior(config))
    odds = np.exp(logs - logs.max())
    out: Floats = odds / odds.sum()
    return out


@numba.njit(cache=True, error_model="numpy")
def _evidence(
    p: Floats,
    covariance: Floats,
    inflation: float,
    floor: float,
    share: float,
    v: float,
    weights: tuple[float, float, float, float],
) -> tuple[Floats, Floats]:
    """Log evidence of each order with its prior; and the least chi2 of each above the dome's, if quadratic."""
    turn = np.array([[0.5, 0.0, 0.5], [0.5, 0.0, -0.5], [0.0, 1.0, 0.0]])
    y = turn @ p[3:]
    s = turn @ np.ascontiguousarray(covariance[3:, 3:]) @ turn.T * inflation
    half = np.hypot(y[1], y[2])
    error = floor**2 + (share * (abs(y[0]) + half)) ** 2
    for a in range(3):
        s[a, a] += error if a == 0 else 0.5 * error
    precision = np.linalg.inv(s)
    weight = precision @ y
    logs, least = np.zeros(4), np.zeros(4)
    chi2 = y @ weight
    least[0] = chi2
    a, b = precision[0, 0], weight[0]
    logs[2] = 0.5 * b * b * v / (1.0 + a * v) - 0.5 * np.log(1.0 + a * v)
    least[2] = chi2 - b * b / a
    free = s.copy()
    free[0, 0] += v / 2.0
    free[1, 1] += v / 4.0
    free[2, 2] += v / 4.0
    logs[3] = 0.5 * (chi2 - y @ np.linalg.solve(free, y)) - 0.5 * np.log(
        np.linalg.det(free) / np.linalg.det(s)
    )
    # a ridge: the angle on a grid as wide as the likelihood needs, round the best
    best = np.arctan2(y[2], y[1]) + (np.pi if y[0] < 0.0 else 0.0)
    spread = np.sqrt(max(s[1, 1], s[2, 2])) / (half + 1e-300)
    width = min(np.pi, 8.0 * spread)
    n = 48
    top, total, most = -np.inf, 0.0, 0.0
    for i in range(n):
        angle = best + width * ((2 * i + 1) / n - 1.0)
        c, d = 0.5 * np.cos(angle), 0.5 * np.sin(angle)
        b = 0.5 * weight[0] + c * weight[1] + d * weight[2]
        a = (
            0.25 * precision[0, 0]
            + c * (precision[0, 1] + c * precision[1, 1] + 2.0 * d * precision[1, 2])
            + d * (precision[0, 2] + d * precision[2, 2])
        )
        log = 0.5 * b * b * v / (1.0 + a * v) - 0.5 * np.log(1.0 + a * v)
        most = max(most, b * b / a)
        if log > top:
            total = total * np.exp(top - log) + 1.0
            top = log
        else:
            total += np.exp(log - top)
    logs[1] = top + np.log(total / n * width / np.pi)
    least[1] = chi2 - most
    for i in range(4):
        logs[i] += np.log(weights[i])
    return logs, least
