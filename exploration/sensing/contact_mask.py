"""Which taxels are in contact, and how high the contact stands beside each.

The plateau next to a taxel is the highest mean of 3 x 3 taxels within `PLATEAU_REACH` response widths; a taxel is
in contact where that rises above the noise and the taxel is deeper than half of it.  Contrast is measured against
this plateau, never against a fixed threshold, so a light press is read like a firm one.
"""

import numba
import numpy as np

from exploration.sensing.frame import TactileImage
from exploration.sensing.response import rubber
from primitives.arrays import Bools, Floats

PLATEAU_REACH = 2.6  # [response widths]
LEAST_PLATEAU = 3.0  # [noise sigma] lower contact is not told from noise


def usable(image: TactileImage) -> bool:
    """Whether the frame can be read at all: finite, dead taxels too, and some taxel alive."""
    return bool(_usable(image.depth, image.sigma))


@numba.njit(cache=True)
def _usable(depth: Floats, sigma: Floats) -> bool:
    alive = False
    for i in range(depth.shape[0]):
        for j in range(depth.shape[1]):
            dead = sigma[i, j] == np.inf
            if not (np.isfinite(depth[i, j]) and (dead or sigma[i, j] > 0.0)):
                return False
            alive |= not dead
    return alive


@numba.njit(cache=True)
def repaired(depth: Floats, sigma: Floats) -> tuple[Floats, Bools]:
    """Depth with each dead taxel replaced by the mean of its living neighbors, and what is alive."""
    rows, columns = depth.shape
    out = depth.copy()
    alive = np.ones((rows, columns), dtype=np.bool_)
    for i in range(rows):
        for j in range(columns):
            if sigma[i, j] == np.inf:
                alive[i, j] = False
                total = 0.0
                count = 0
                for a in range(max(0, i - 1), min(rows, i + 2)):
                    for b in range(max(0, j - 1), min(columns, j + 2)):
                        if sigma[a, b] != np.inf:
                            total += depth[a, b]
                            count += 1
                out[i, j] = total / count if count else 0.0
    return out, alive


@numba.njit(cache=True)
def local_plateau(depth: Floats, reach_rows: int, reach_columns: int) -> Floats:
    """The highest 3 x 3 mean within the reach, in taxels, of each taxel."""
    rows, columns = depth.shape
    mean = np.empty((rows, columns))
    for i in range(rows):
        for j in range(columns):
            total = 0.0
            count = 0
            for a in range(max(0, i - 1), min(rows, i + 2)):
                for b in range(max(0, j - 1), min(columns, j + 2)):
                    total += depth[a, b]
                    count += 1
            mean[i, j] = total / count
    along = np.empty((rows, columns))
    for i in range(rows):
        for j in range(columns):
            high = mean[i, j]
            for b in range(max(0, j - reach_columns), min(columns, j + reach_columns + 1)):
                high = max(high, mean[i, b])
            along[i, j] = high
    out = np.empty((rows, columns))
    for i in range(rows):
        for j in range(columns):
            high = along[i, j]
            for a in range(max(0, i - reach_rows), min(rows, i + reach_rows + 1)):
                high = max(high, along[a, j])
            out[i, j] = high
    return out


@numba.njit(cache=True)
def plateau_of(depth: Floats, px: float, py: float, width: float) -> Floats:
    """`local_plateau` within `PLATEAU_REACH` of a response width [mm]."""
    reach = PLATEAU_REACH * width
    plateau: Floats = local_plateau(depth, int(np.ceil(reach / py)), int(np.ceil(reach / px)))
    return plateau


@numba.njit(cache=True)
def noise_of(sigma: Floats) -> float:
    """[mm] mean standard deviation of the living taxels."""
    total = 0.0
    count = 0
    for i in range(sigma.shape[0]):
        for j in range(sigma.shape[1]):
            if sigma[i, j] != np.inf:
                total += sigma[i, j]
                count += 1
    return total / max(1, count)


@numba.njit(cache=True)
def touched(depth: Floats, sigma: Floats, px: float, py: float, width: float) -> Bools:
    """The contact mask of a repaired frame."""
    noise = noise_of(sigma)
    plateau = plateau_of(depth, px, py, width)
    out = np.zeros(depth.shape, dtype=np.bool_)
    for i in range(depth.shape[0]):
        for j in range(depth.shape[1]):
            out[i, j] = plateau[i, j] > LEAST_PLATEAU * noise and depth[i, j] > 0.5 * plateau[i, j]
    return out


def contact_mask(image: TactileImage) -> Bools:
    """Taxels in contact."""
    px, py = image.array.pitch
    width = rubber(image.spread, image.array.pitch).mean_width
    mask: Bools = touched(repaired(image.depth, image.sigma)[0], image.sigma, px, py, width)
    return mask
