"""The grain of a rough surface: one fixed random field of heights in space, cut by whatever surface lies in it.

White noise on a periodic lattice of `step` = l/2 is filtered to the autocovariance exp(-r^2 / (2 l^2)), l being
the grain's size, and read between the lattice's nodes by trilinear interpolation.  That lowers its variance, on
average to ((2 + rho) / 3)^3 with rho = exp(-step^2 / (2 l^2)), which is made up for (our derivation).  The lattice
lies askew, so that no straight stroke meets the same heights again after one period.
"""

from functools import lru_cache

import numpy as np
from numba import njit

from primitives.arrays import Floats, frozen
from primitives.pose import rotation_exp

NODES = 64  # along each axis of the lattice
STEP = 0.5  # [grain sizes] between nodes
ASKEW = frozen(rotation_exp([0.61, 0.97, 1.43]))


class Grain:
    """Heights of unit root mean square, the same at the same place for the same seed."""

    def __init__(self, size: float = 1.0, seed: int = 0) -> None:
        """`size` [mm] is the length over which heights are alike."""
        self._lattice, self._step = _lattice(seed), STEP * size

    def at(self, points: Floats) -> Floats:
        """(n,) heights at (n, 3) points [mm]."""
        out = np.empty(len(points))
        _read(self._lattice, np.ascontiguousarray(points @ ASKEW), 1.0 / self._step, out)
        return out


@lru_cache(maxsize=4)
def _lattice(seed: int) -> Floats:
    white = np.random.default_rng(seed).standard_normal((NODES,) * 3)
    k = 2.0 * np.pi * np.fft.fftfreq(NODES)
    # the square root of the spectrum of exp(-r^2 / (2 l^2)) is that of a Gaussian of variance l^2 / 2
    along = np.exp(-((k / STEP) ** 2) / 4.0)
    kept = along[:, None, None] * along[None, :, None] * along[None, None, :]
    smooth = np.fft.ifftn(np.fft.fftn(white) * kept).real
    rho = np.exp(-(STEP**2) / 2.0)
    return frozen((smooth - smooth.mean()) / smooth.std() / ((2.0 + rho) / 3.0) ** 1.5)


@njit(cache=True, error_model="numpy")
def _read(lattice: Floats, points: Floats, per_mm: float, out: Floats) -> None:
    n = lattice.shape[0]
    for p in range(len(points)):
        x, y, z = points[p, 0] * per_mm, points[p, 1] * per_mm, points[p, 2] * per_mm
        fx, fy, fz = np.floor(x), np.floor(y), np.floor(z)
        i, j, k = int(fx) % n, int(fy) % n, int(fz) % n
        u, v, w = x - fx, y - fy, z - fz
        i1, j1, k1 = (i + 1) % n, (j + 1) % n, (k + 1) % n
        low = (1.0 - u) * ((1.0 - v) * lattice[i, j, k] + v * lattice[i, j1, k])
        low += u * ((1.0 - v) * lattice[i1, j, k] + v * lattice[i1, j1, k])
        high = (1.0 - u) * ((1.0 - v) * lattice[i, j, k1] + v * lattice[i, j1, k1])
        high += u * ((1.0 - v) * lattice[i1, j, k1] + v * lattice[i1, j1, k1])
        out[p] = (1.0 - w) * low + w * high
