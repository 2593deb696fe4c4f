"""What the servo needs from a frame, every tick: how deep, how sloped, where, how sharp.

depth(r) = d + g . (r - c) - 1/2 (r - c)^T K (r - c) is fitted to the touched taxels by linear least squares
around the contact's centroid c; the slope at the pad's center is g + K c, which is the pad's tilt against a flat
face and, on a curved one, says how far the contact lies off the middle.  The rubber's spread s lowers a curved
contact's peak by s^2 tr(K) / 2, which is added back.  Within two taxels of where contact ends inside the pad the
spread bends the profile, so that rim is left out wherever enough remains (our derivation).
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.ndimage import binary_erosion, uniform_filter

from exploration.sensing.frame import TactileImage
from primitives.arrays import Bools, Floats


@dataclass(frozen=True)
class FeelConfig:
    """Which taxels count, and how the curvature is held where they say nothing of it."""

    sigmas: float = 4.0  # standard deviations that a touched taxel stands out of the noise
    share: float = 0.35  # of the peak, below which a taxel counts as untouched
    rim: int = 2  # taxels left out along the contact's end inside the pad
    enough: int = 15  # taxels that must remain for the rim to be left out
    prior_curvature: float = 0.03  # [1/mm] of what is too small to be seen whole
    prior_sigma: float = 0.03  # [1/mm]


@dataclass(frozen=True)
class Felt:
    """One frame in a few numbers."""

    depth: float  # [mm] at the contact's middle, as if the rubber did not spread
    slope: Floats  # (2,) [mm/mm] of depth at the pad's center
    centroid: Floats  # (2,) [mm]
    curvature: Floats  # (2,) [1/mm] principal, larger first; positive where the object is convex
    hessian: Floats  # (2, 2) [1/mm] the same in the pad's axes
    area: float  # [mm^2] of the touched taxels
    mask: Bools  # (rows, columns) touched
    inner: Bools  # (rows, columns) touched, and away from where contact ends inside the pad


@dataclass(frozen=True)
class NotTouching:
    """Nothing was felt; false in a condition."""

    reason: str = "no taxel stands out of the noise"

    def __bool__(self) -> Literal[False]:
        return False


def feel(image: TactileImage, config: FeelConfig = FeelConfig()) -> Felt | NotTouching:
    """Fit the local paraboloid to one frame."""
    live = np.isfinite(image.sigma)
    if not live.any():
        return NotTouching("every taxel is dead")
    sigma = float(np.median(image.sigma[live]))
    depth = np.where(live, image.depth, 0.0)
    smooth = uniform_filter(depth, 3, mode="nearest")
    peak = float(smooth.max())
    if peak < config.sigmas * sigma / 2.0:
        return NotTouching()
    mask = live & (smooth > max(config.share * peak, 1.5 * sigma))
    inner = live & binary_erosion(mask, iterations=config.rim, border_value=1)
    used = inner if int(inner.sum()) >= config.enough and _spans(inner, 3) else mask
    x, y = image.array.x, image.array.y
    rows, columns = np.nonzero(used)
    px, py, d = x[columns], y[rows], depth[rows, columns]
    weight = np.maximum(smooth[rows, columns], 0.0)
    centroid = np.array([px @ weight, py @ weight]) / weight.sum()
    u, v = px - centroid[0], py - centroid[1]
    basis = np.stack([np.ones_like(u), u, v, -0.5 * u * u, -u * v, -0.5 * v * v], axis=1) / sigma
    information = basis.T @ basis
    right = basis.T @ (d / sigma)
    hold = 1.0 / config.prior_sigma**2
    information[[1, 2], [1, 2]] += 1.0
    information[[3, 4, 5], [3, 4, 5]] += hold
    right[[3, 5]] += hold * config.prior_curvature
    c = np.linalg.solve(information, right)
    k = np.array([[c[3], c[4]], [c[4], c[5]]])
    middle, spread = (c[3] + c[5]) / 2.0, float(np.hypot((c[3] - c[5]) / 2.0, c[4]))
    return Felt(
        depth=float(c[0] + 0.5 * image.spread**2 * max(c[3] + c[5], 0.0)),
        slope=c[1:3] + k @ centroid,
        centroid=centroid,
        curvature=np.array([middle + spread, middle - spread]),
        hessian=k,
        area=float(mask.sum()) * image.array.pitch[0] * image.array.pitch[1],
        mask=mask,
        inner=inner,
    )


def _spans(mask: Bools, least: int) -> bool:
    """Whether the mask covers at least so many rows and columns."""
    return int(mask.any(axis=0).sum()) >= least and int(mask.any(axis=1).sum()) >= least
