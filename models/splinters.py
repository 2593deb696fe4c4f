"""Splinters: bodies that are only what rounding cut off another, or left between two."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from primitives.arrays import Bools, Floats

_THIN = 1e-3  # of the longest side of the largest body,
_THINNEST = 0.02  # [mm] and in all, the thickness that a splinter does not have
_LITTLE = 1e-3  # of that body's volume, at most a splinter's


def splinters(volumes: ArrayLike, areas: ArrayLike, bounds: Sequence[Floats]) -> Bools:
    """(n,) which bodies are splinters, of their volumes [mm^3], areas [mm^2] and (2, 3) bounds [mm].

    Twice the volume over the area is the thickness of a sheet, and half that of a rod (our derivation); the volume
    of a cavity may be negative.
    """
    volume, corners = np.abs(np.asarray(volumes, dtype=np.float64)), np.asarray(bounds).reshape(-1, 2, 3)
    if len(volume) < 2:
        return np.zeros(len(volume), dtype=bool)
    largest = int(volume.argmax())
    size = float((corners[largest, 1] - corners[largest, 0]).max())
    thin = 2.0 * volume < min(_THIN * size, _THINNEST) * np.asarray(areas)
    return np.asarray(thin & (volume < _LITTLE * volume[largest]))
