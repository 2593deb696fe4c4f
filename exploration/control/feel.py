"""What the servo needs from a frame, every tick: how deep, how sloped, where, how sharp.

depth(r) = d + g . (r - c) - 1/2 (r - c)^T K (r - c) is fitted to the touched taxels by linear least squares
around the contact's centroid c; the slope at the pad's center is g + K c, which is the pad's tilt against a flat
face and, on a curved one, says how far the contact lies off the middle.  The rubber's spread s lowers a curved
contact's peak by s^2 tr(K) / 2, which is added back.  Within two taxels of where contact ends inside the pad the
spread bends the profile, so that rim is left out wherever enough remains (our derivation).
"""

from dataclasses import dataclass
from typing import Literal

import numba
import numpy as np
from scipy.ndimage import uniform_filter

from exploration.sensing.frame import TactileImage, TaxelArray
from primitives.arrays import Bools, Floats


@dataclass(frozen=True)
class FeelConfig:
    """Which taxels count, and how the curvature is held where they say nothing of it."""

    sigmas: float = 4.0  # standard deviations that a touched taxel stands out of the noise
    share: float = 0.35  # of the peak, below which a taxel counts as untouched
    rim: float = 2.0  # [spreads of the rubber] left out along the contact's end inside the pad
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
    array = image.array
    live = np.isfinite(image.sigma)
    if not live.any():
        return NotTouching("every taxel is dead")
    depth = np.where(live, image.depth, 0.0)
    touching, mask, inner, centroid, c = _fitted(
        depth,
        uniform_filter(depth, 3, mode="nearest"),
        image.sigma,
        array.x,
        array.y,
        (config.sigmas, config.share, _taxels(config.rim * image.spread, array), config.enough),
        (config.prior_curvature, config.prior_sigma),
    )
    if not touching:
        return NotTouching()
    k = np.array([[c[3], c[4]], [c[4], c[5]]])
    middle, spread = (c[3] + c[5]) / 2.0, float(np.hypot((c[3] - c[5]) / 2.0, c[4]))
    return Felt(
        depth=float(c[0] + 0.5 * image.spread**2 * max(c[3] + c[5], 0.0)),
        slope=c[1:3] + k @ centroid,
        centroid=centroid,
        curvature=np.array([middle + spread, middle - spread]),
        hessian=k,
        area=float(mask.sum()) * array.pitch[0] * array.pitch[1],
        mask=mask,
        inner=inner,
    )


def _taxels(length: float, array: TaxelArray) -> int:
    """How many taxels, at least one, reach so far [mm]."""
    return max(1, int(np.ceil(length / max(array.pitch) - 1e-6)))


@numba.njit(cache=True, error_model="numpy")
def _fitted(
    depth: Floats,
    smooth: Floats,
    noise: Floats,
    x: Floats,
    y: Floats,
    taxels: tuple[float, float, int, int],
    prior: tuple[float, float],
) -> tuple[bool, Bools, Bools, Floats, Floats]:
    """Whether anything is touched, the masks, their centroid, and d, g and K about it."""
    sigmas, share, rim, enough = taxels
    curvature, curvature_sigma = prior
    live = np.isfinite(noise)
    sigma = np.median(noise.ravel()[live.ravel()])
    peak = smooth.max()
    mask = live & (smooth > max(share * peak, 1.5 * sigma))
    inner = mask.copy()
    for _ in range(rim):
        inner = _eroded(inner)
    centroid, c = np.zeros(2), np.zeros(6)
    if peak < sigmas * sigma / 2.0:
        return False, mask, inner, centroid, c
    rows, columns = (inner if inner.sum() >= enough and _spans(inner, 3) else mask).nonzero()
    total = 0.0
    for i, j in zip(rows, columns):  # noqa: B905 (numba's zip knows no strict)
        weight = max(smooth[i, j], 0.0)
        total += weight
        centroid[0] += weight * x[j]
        centroid[1] += weight * y[i]
    centroid /= total
    basis = np.empty((len(rows), 6))
    felt = np.empty(len(rows))
    for k in range(len(rows)):
        u, v = x[columns[k]] - centroid[0], y[rows[k]] - centroid[1]
        basis[k] = (1.0, u, v, -0.5 * u * u, -u * v, -0.5 * v * v)
        felt[k] = depth[rows[k], columns[k]]
    hold = curvature_sigma**-2.0
    information = basis.T @ basis / sigma**2 + np.diag(np.array([0.0, 1.0, 1.0, hold, hold, hold]))
    right = basis.T @ felt / sigma**2 + np.array([0.0, 0.0, 0.0, hold * curvature, 0.0, hold * curvature])
    return True, mask, inner, centroid, np.linalg.solve(information, right)


@numba.njit(cache=True)
def _eroded(mask: Bools) -> Bools:
    """Without the taxels beside one that is not touched; what lies off the pad counts as touched."""
    out = mask.copy()
    out[1:] &= mask[:-1]
    out[:-1] &= mask[1:]
    out[:, 1:] &= mask[:, :-1]
    out[:, :-1] &= mask[:, 1:]
    return out


@numba.njit(cache=True)
def _spans(mask: Bools, least: int) -> bool:
    """Whether the mask covers at least so many rows and columns."""
    rows, columns = mask.nonzero()
    return len(np.unique(rows)) >= least and len(np.unique(columns)) >= least
