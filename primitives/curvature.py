"""Principal curvatures from normal curvatures felt along four directions, 45 degrees apart.

Euler: kappa(phi) = k1 cos^2(phi - theta) + k2 sin^2(phi - theta) = H + A cos 2 phi + B sin 2 phi, so that at
phi = 0, 45, 90, 135 degrees::

    H = (k0 + k45 + k90 + k135) / 4,    A = (k0 - k90) / 2,    B = (k45 - k135) / 2,    D = hypot(A, B),
    k1 = H + D,    k2 = H - D,    theta = atan2(B, A) / 2.

Four readings for three unknowns leave one test: k0 + k90 - k45 - k135 is zero but for noise, of standard
deviation 2 sigma.  D is biased up near zero, where theta means nothing, so the order of the surface is never
judged by a threshold on D: `name_order` integrates the likelihood of (H, A, B), which are Gaussian, over each
order's curvatures (our derivation).  Curvatures are in 1/mm, positive where a solid is convex.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import erfc

from primitives.arrays import Floats, frozen

# rows: H, A, B, redundancy; columns: k0, k45, k90, k135
_COMBINE = frozen(
    [[0.25, 0.25, 0.25, 0.25], [0.5, 0.0, -0.5, 0.0], [0.0, 0.5, 0.0, -0.5], [1.0, -1.0, 1.0, -1.0]]
)

ORDERS = ("plane", "cylinder or cone", "sphere", "other")


@dataclass(frozen=True)
class FourCurvatures:
    """What n four-direction measurements say."""

    k1: Floats  # (n,) [1/mm] the larger principal curvature
    k2: Floats  # (n,) [1/mm] the smaller
    theta: Floats  # (n,) [rad] direction of k1 from the first direction, in (-pi/2, pi/2]
    covariance: Floats  # (n, 3, 3) of (k1, k2, theta), linearized: good where k1 - k2 is well above its sigma
    components: Floats  # (n, 3) H, A, B [1/mm]: linear in the readings, unbiased everywhere
    components_covariance: Floats  # (n, 3, 3)
    redundancy: Floats  # (n,) [1/mm] k0 + k90 - k45 - k135
    z: Floats  # (n,) the redundancy in its standard deviations
    consistency: Floats  # (n,) probability of a redundancy at least as large, were the surface smooth


@dataclass(frozen=True)
class OrderPrior:
    """What is assumed about curvatures before they are felt."""

    scale: float = 0.1  # [1/mm] standard deviation of the curvature of what is curved: radii about 10 mm
    weights: tuple[float, float, float, float] = (0.4, 0.3, 0.2, 0.1)  # of ORDERS


def from_four(
    k0: ArrayLike, k45: ArrayLike, k90: ArrayLike, k135: ArrayLike, sigma: ArrayLike
) -> FourCurvatures:
    """Principal curvatures of (n,) readings [1/mm] with standard deviations `sigma`, one, (n,) or (n, 4)."""
    readings = np.stack(np.broadcast_arrays(*np.atleast_1d(k0, k45, k90, k135)), axis=-1).astype(float)
    sigmas = np.asarray(sigma, dtype=float)
    sigmas = np.broadcast_to(sigmas[..., None] if sigmas.ndim < 2 else sigmas, readings.shape)
    linear = readings @ _COMBINE.T
    spread = np.einsum("ij,nj,kj->nik", _COMBINE, sigmas**2, _COMBINE)
    h, a, b, redundancy = linear.T
    d = np.hypot(a, b)
    safe = np.maximum(d, 1e-300)
    unit_a, unit_b = np.where(d > 0, a / safe, 1.0), b / safe
    jacobian = np.zeros((len(h), 3, 3))
    jacobian[:, 0, 0] = jacobian[:, 1, 0] = 1.0
    jacobian[:, 0, 1], jacobian[:, 0, 2] = unit_a, unit_b
    jacobian[:, 1, 1], jacobian[:, 1, 2] = -unit_a, -unit_b
    slack = 2.0 * np.maximum(d, np.sqrt(spread[:, 1, 1]) * 1e-3)  # theta's sigma stays finite at an umbilic
    jacobian[:, 2, 1], jacobian[:, 2, 2] = -unit_b / slack, unit_a / slack
    covariance = jacobian @ spread[:, :3, :3] @ np.swapaxes(jacobian, 1, 2)
    z = redundancy / np.sqrt(spread[:, 3, 3])
    return FourCurvatures(
        frozen(h + d),
        frozen(h - d),
        frozen(0.5 * np.arctan2(b, a)),
        frozen(covariance),
        frozen(linear[:, :3]),
        frozen(spread[:, :3, :3]),
        frozen(redundancy),
        frozen(z),
        frozen(erfc(np.abs(z) / np.sqrt(2.0))),
    )


def normal_curvature(section: ArrayLike, tilt: ArrayLike) -> Floats:
    """Meusnier: the normal curvature under a section tilted by `tilt` [rad] from the surface normal."""
    return np.asarray(np.asarray(section, dtype=float) * np.cos(tilt))


def name_order(felt: FourCurvatures, prior: OrderPrior | None = None) -> Floats:
    """(n, 4) probabilities of ORDERS; "other" has two different curvatures, neither of them zero."""
    prior = prior or OrderPrior()
    y, noise = felt.components, felt.components_covariance
    variance = prior.scale**2
    round_ = np.diag([variance, 0.0, 0.0])
    free = np.diag([variance / 2, variance / 4, variance / 4])  # two independent curvatures at any angle
    logs = np.stack(
        [
            _log_gaussian(y, noise),
            _log_ridge(y, noise, variance, felt),
            _log_gaussian(y, noise + round_),
            _log_gaussian(y, noise + free),
        ],
        axis=1,
    )
    logs = logs + np.log(np.asarray(prior.weights))
    weights = np.exp(logs - logs.max(axis=1, keepdims=True))
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))


def _log_gaussian(y: Floats, covariance: Floats) -> Floats:
    solved = np.linalg.solve(covariance, y[..., None])[..., 0]
    return np.asarray(-0.5 * ((y * solved).sum(axis=-1) + np.linalg.slogdet(covariance)[1]))


def _log_ridge(y: Floats, noise: Floats, variance: float, felt: FourCurvatures) -> Floats:
    """One curvature k ~ N(0, variance) at a uniform angle: (H, A, B) = k/2 (1, cos, sin), a rank-one spread.

    The angle is integrated on a grid as wide as the likelihood needs, round the best angle of either sign of k.
    """
    width = np.minimum(np.pi, 16.0 * np.sqrt(felt.covariance[:, 2, 2]))  # of 2 theta
    grid = np.linspace(-1.0, 1.0, 97)
    best = 2.0 * felt.theta + np.where(felt.components[:, 0] < 0, np.pi, 0.0)
    angle = best[:, None] + width[:, None] * grid
    ray = 0.5 * np.stack([np.ones_like(angle), np.cos(angle), np.sin(angle)], axis=-1)
    covariance = noise[:, None] + variance * ray[..., :, None] * ray[..., None, :]
    logs = _log_gaussian(np.broadcast_to(y[:, None], ray.shape), covariance)
    top = logs.max(axis=1)
    mean = np.exp(logs - top[:, None]).mean(axis=1) * width / np.pi
    return np.asarray(top + np.log(mean))
