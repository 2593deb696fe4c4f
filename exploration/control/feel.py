"""What the servo needs from a frame, every tick: how deep, how sloped, where, how sharp.

depth(r) = d + g . (r - c) - 1/2 (r - c)^T K (r - c) is fitted to the touched taxels by linear least squares
around the contact's centroid c; the slope at the pad's center is g + K c, which is the pad's tilt against a flat
face and, on a curved one, says how far the contact lies off the middle.  The rubber's spread s lowers a curved
contact's peak by s^2 tr(K) / 2, which is added back.  Within two taxels of where contact ends inside the pad the
spread bends the profile, so that rim is left out wherever enough remains.  Over a groove nothing is touched in the
middle, which says nothing of how deep the pad lies on the lands beside it: their mean does.  A bowl that the pad's
corners touch bends up both ways, and is no groove (our derivation).
"""

from dataclasses import dataclass
from typing import Literal

import numba
import numpy as np

from exploration.sensing.frame import TactileImage, TaxelArray
from primitives.arrays import Bools, Floats

NO_TAXEL, NOTHING, TOUCHED = range(3)


@dataclass(frozen=True)
class FeelConfig:
    """Which taxels count, and how the curvature is held where they say nothing of it."""

    sigmas: float = 4.0  # standard deviations that a touched taxel stands out of the noise
    share: float = 0.35  # of the peak, below which a taxel counts as untouched
    rim: float = 2.0  # [spreads of the rubber] left out along the contact's end inside the pad
    enough: int = 15  # taxels that must remain for the rim to be left out, or for a groove to be told
    untouched: float = 0.1  # of the peak, up to which the middle is over a groove,
    hardly: float = 0.3  # and from which it is over none
    hollow: float = -0.01  # [1/mm] greater curvature of what is hollow both ways, and no groove
    prior_curvature: float = 0.03  # [1/mm] of what is too small to be seen whole
    prior_sigma: float = 0.03  # [1/mm]


@dataclass(frozen=True)
class Felt:
    """One frame in a few numbers."""

    depth: float  # [mm] at the contact's middle, as if the rubber did not spread; over a groove that of its lands
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
    found, touched, inner, numbers, hessian = _fitted(
        image.depth,
        image.sigma,
        array.x,
        array.y,
        image.spread,
        (config.sigmas, config.share, _taxels(config.rim * image.spread, array), config.enough),
        (config.prior_curvature, config.prior_sigma),
        (config.untouched, config.hardly, config.hollow),
    )
    if found == NO_TAXEL:
        return NotTouching("every taxel is dead")
    if found == NOTHING:
        return NotTouching()
    return Felt(
        depth=float(numbers[0]),
        slope=numbers[1:3],
        centroid=numbers[3:5],
        curvature=numbers[5:7],
        hessian=hessian,
        area=float(numbers[7]) * array.pitch[0] * array.pitch[1],
        mask=touched,
        inner=inner,
    )


def _taxels(length: float, array: TaxelArray) -> int:
    """How many taxels, at least one, reach so far [mm]."""
    return max(1, int(np.ceil(length / max(array.pitch) - 1e-6)))


@numba.njit(cache=True, error_model="numpy")
def _fitted(
    depth: Floats,
    noise: Floats,
    x: Floats,
    y: Floats,
    spread: float,
    taxels: tuple[float, float, int, int],
    prior: tuple[float, float],
    grooved: tuple[float, float, float],
) -> tuple[int, Bools, Bools, Floats, Floats]:
    """What is touched, the masks, the numbers of `Felt` up to its curvature and a count of taxels, and K."""
    sigmas, share, rim, enough = taxels
    curvature, curvature_sigma = prior
    untouched, hardly, hollow = grooved
    numbers, hessian = np.zeros(8), np.zeros((2, 2))
    mask, inner = np.zeros(depth.shape, np.bool_), np.zeros(depth.shape, np.bool_)
    smooth, sigma = _smoothed(depth, noise)
    if not np.isfinite(sigma):
        return NO_TAXEL, mask, inner, numbers, hessian
    peak = smooth.max()
    if not peak >= sigmas * sigma / 2.0:
        return NOTHING, mask, inner, numbers, hessian
    least = max(share * peak, 1.5 * sigma)
    count = 0
    for i in range(len(y)):
        for j in range(len(x)):
            mask[i, j] = inner[i, j] = noise[i, j] < np.inf and smooth[i, j] > least
            count += mask[i, j]
    for _ in range(rim):
        inner = _eroded(inner)
    use = inner if _is_enough(inner, enough, 3) else mask
    total, cx, cy, mean, used = 0.0, 0.0, 0.0, 0.0, 0
    for i in range(len(y)):
        for j in range(len(x)):
            if use[i, j]:
                weight = max(smooth[i, j], 0.0)
                total += weight
                mean += depth[i, j]
                used += 1
                cx += weight * x[j]
                cy += weight * y[i]
    cx, cy = cx / total, cy / total
    information, right, row = np.zeros((6, 6)), np.zeros(6), np.empty(6)
    for i in range(len(y)):
        for j in range(len(x)):
            if use[i, j]:
                u, v = x[j] - cx, y[i] - cy
                row[0], row[1], row[2], row[3], row[4], row[5] = 1.0, u, v, -0.5 * u * u, -u * v, -0.5 * v * v
                for a in range(6):
                    right[a] += row[a] * depth[i, j]
                    for b in range(a + 1):
                        information[a, b] += row[a] * row[b]
    hold = (sigma / curvature_sigma) ** 2
    for a in range(1, 6):
        information[a, a] += hold if a > 2 else sigma**2
    right[3] += hold * curvature
    right[5] += hold * curvature
    c = _solved(information, right)
    numbers[0] = c[0] + 0.5 * spread**2 * max(c[3] + c[5], 0.0)
    numbers[1], numbers[2] = c[1] + c[3] * cx + c[4] * cy, c[2] + c[4] * cx + c[5] * cy
    numbers[3], numbers[4] = cx, cy
    middle, half = (c[3] + c[5]) / 2.0, np.hypot((c[3] - c[5]) / 2.0, c[4])
    numbers[5], numbers[6], numbers[7] = middle + half, middle - half, count
    hessian[0, 0], hessian[0, 1], hessian[1, 0], hessian[1, 1] = c[3], c[4], c[4], c[5]
    in_middle = smooth[np.argmin(np.abs(y - cy)), np.argmin(np.abs(x - cx))] / peak
    if used >= enough and in_middle < hardly and numbers[5] > hollow:
        lands = max(mean / used - numbers[0], 0.0)
        numbers[0] += lands * min((hardly - in_middle) / (hardly - untouched), 1.0)
    return TOUCHED, mask, inner, numbers, hessian


@numba.njit(cache=True, error_model="numpy")
def _smoothed(depth: Floats, noise: Floats) -> tuple[Floats, float]:
    """Means of 3 x 3 taxels, of dead ones as zero and the rim's own beyond it; the living ones' median noise."""
    rows, columns = depth.shape
    across, out, living = np.empty(depth.shape), np.empty(depth.shape), np.empty(depth.size)
    n = 0
    for i in range(rows):
        before = here = depth[i, 0] if np.isfinite(noise[i, 0]) else 0.0
        for j in range(columns):
            if np.isfinite(noise[i, j]):
                living[n] = noise[i, j]
                n += 1
            k = min(j + 1, columns - 1)
            after = depth[i, k] if np.isfinite(noise[i, k]) else 0.0
            across[i, j] = before + here + after
            before, here = here, after
    for i in range(rows):
        up, down = max(i - 1, 0), min(i + 1, rows - 1)
        for j in range(columns):
            out[i, j] = (across[up, j] + across[i, j] + across[down, j]) / 9.0
    return out, (np.median(living[:n]) if n else np.inf)


@numba.njit(cache=True, error_model="numpy")
def _solved(lower: Floats, right: Floats) -> Floats:
    """Of positive definite normal equations, whose lower half is given (Cholesky, in place)."""
    n = len(right)
    for a in range(n):
        for b in range(a + 1):
            value = lower[a, b]
            for k in range(b):
                value -= lower[a, k] * lower[b, k]
            lower[a, b] = np.sqrt(value) if a == b else value / lower[b, b]
    for a in range(n):
        for k in range(a):
            right[a] -= lower[a, k] * right[k]
        right[a] /= lower[a, a]
    for a in range(n - 1, -1, -1):
        for k in range(a + 1, n):
            right[a] -= lower[k, a] * right[k]
        right[a] /= lower[a, a]
    return right


@numba.njit(cache=True)
def _eroded(mask: Bools) -> Bools:
    """Without the taxels beside one that is not touched; what lies off the pad counts as touched."""
    rows, columns = mask.shape
    out = np.empty(mask.shape, np.bool_)
    for i in range(rows):
        for j in range(columns):
            out[i, j] = (
                mask[i, j]
                and mask[max(i - 1, 0), j]
                and mask[min(i + 1, rows - 1), j]
                and mask[i, max(j - 1, 0)]
                and mask[i, min(j + 1, columns - 1)]
            )
    return out


@numba.njit(cache=True)
def _is_enough(mask: Bools, taxels: int, least: int) -> bool:
    """Whether a mask holds so many taxels, over at least so many rows and columns."""
    count, rows = 0, 0
    in_column = np.zeros(mask.shape[1], np.bool_)
    for i in range(mask.shape[0]):
        any_here = False
        for j in range(mask.shape[1]):
            if mask[i, j]:
                count += 1
                any_here = True
                in_column[j] = True
        rows += any_here
    return count >= taxels and rows >= least and in_column.sum() >= least
