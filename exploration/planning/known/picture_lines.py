"""A flat face along straight lines across its picture: how much of it is there, and where it begins."""

from __future__ import annotations

import numpy as np

from exploration.planning.known.mosaic import Lattice, Mosaic
from primitives.arrays import Floats

_MARGIN = 1.0  # [mm] round the places that are asked for
_THERE = 0.5  # share of a face, from which on it is there


def share_at(mosaic: Mosaic, normal: Floats, places: Floats, along: Floats) -> Floats:
    """(...) of the face of (3,) outward normal at (..., 3) places in its plane; NaN where nobody saw.

    The picture is drawn along two directions of the plane, the columns of (3, 2) `along`.
    """
    lattice = Lattice.over(places.reshape(-1, 3), along, mosaic.config.step, _MARGIN)
    seen = mosaic.picture(places.reshape(-1, 3)[0], normal, lattice)
    row, column = np.moveaxis(np.round((places @ along - lattice.origin) / lattice.step).astype(int), -1, 0)
    return np.where(seen.known[row, column], seen.share[row, column], np.nan)


def begins(out: Floats, share: Floats) -> float | None:
    """Where on the way (n,) `out` of an opening a face begins, by its (n,) share; None where that was not seen."""
    k = int(np.argmax(share > _THERE))
    if k == 0 or not np.isfinite(share[: k + 1]).all():
        return None
    return float(np.interp(_THERE, share[k - 1 : k + 1], out[k - 1 : k + 1]))
