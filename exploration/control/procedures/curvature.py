"""Four-direction curvature: what kind of surface lies under the pad (Fan's method, as the CMU report cites it).

Along each of four lines through the contact's middle, 45 degrees apart, depth(s) = d + g s - k s^2 / 2 is fitted
to the touched taxels beside the line; the four normal curvatures k give the principal ones and a redundancy that
tells whether the patch is smooth.  The pad lies on the surface, so the sections are normal to it.  The spread of
the rubber leaves the curvature of a paraboloid as it is but flattens its rim, so that narrow contacts read up to a
quarter blunt (our derivation).

Property class: structural (exact shape).
"""

from dataclasses import dataclass

import numpy as np

from exploration.control.feel import Felt
from exploration.sensing.frame import TactileImage
from primitives.arrays import Floats
from primitives.curvature import ORDERS, FourCurvatures, from_four, name_order

DIRECTIONS = np.radians([0.0, 45.0, 90.0, 135.0])


@dataclass(frozen=True)
class CurvatureConfig:
    """Which taxels speak for a direction."""

    beside: float = 1.3  # [pitches] from the line
    taxels: int = 5  # least number; with fewer the direction is uncertain
    blunt: float = 0.12  # share of the greatest reading by which the rubber may falsify any
    unknown: float = 0.2  # [1/mm] standard deviation of a direction that cannot be measured


@dataclass(frozen=True)
class FeltCurvature:
    """The surface under the pad, by its order of curvature."""

    four: FourCurvatures
    order: str  # the likeliest of `primitives.curvature.ORDERS`
    probability: float
    ridge: Floats  # (2,) unit direction of least curvature, in the pad's axes


def four_direction_curvature(
    image: TactileImage, felt: Felt, config: CurvatureConfig = CurvatureConfig()
) -> FeltCurvature:
    """Curvature in four directions from one frame, best an averaged one."""
    readings = [_along(image, felt, angle, config) for angle in DIRECTIONS]
    k = np.array([value for value, _ in readings])
    sigma = np.array([s for _, s in readings])
    sigma = np.hypot(sigma, config.blunt * np.abs(k).max())
    four = from_four(k[:1], k[1:2], k[2:3], k[3:], sigma[None])
    chances = name_order(four)[0]
    across = float(four.theta[0])
    return FeltCurvature(
        four,
        ORDERS[int(np.argmax(chances))],
        float(chances.max()),
        np.array([-np.sin(across), np.cos(across)]),
    )


def _along(image: TactileImage, felt: Felt, angle: float, config: CurvatureConfig) -> tuple[float, float]:
    """Curvature and its standard deviation [1/mm] along one line through the contact's middle."""
    rows, columns = np.nonzero(felt.mask & np.isfinite(image.sigma))
    x, y = image.array.x[columns] - felt.centroid[0], image.array.y[rows] - felt.centroid[1]
    s, t = np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x
    near = np.abs(t) < config.beside * max(image.array.pitch)
    if int(near.sum()) < config.taxels:
        return 0.0, config.unknown
    depth, sigma = image.depth[rows, columns][near], image.sigma[rows, columns][near]
    s, t = s[near], t[near]  # what varies across the strip is fitted too, and forgotten
    basis = np.stack([np.ones_like(s), s, -0.5 * s**2, t, s * t, t**2], axis=1) / sigma[:, None]
    information = basis.T @ basis + np.diag([1e-9, 1e-9, *[config.unknown**-2] * 4])
    covariance = np.linalg.inv(information)
    return float((covariance @ basis.T @ (depth / sigma))[2]), float(np.sqrt(covariance[2, 2]))
