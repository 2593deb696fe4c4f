"""Frames of several arrays on one stage, laid on the grid of the first, so that one page plays all of them.

Each taxel of the grid shows the nearest one of the array that felt, in mm from the pad's center, and rests
where that array has no skin.  Signals are in shares of the full contact of each, given in the first one's counts.
"""

from __future__ import annotations

import numpy as np

from exploration.sensing.spec import SensorSpec
from primitives.arrays import Floats


def laid(counts: Floats, spec: SensorSpec, onto: SensorSpec) -> Floats:
    """(rows, columns) counts of `onto`, for one frame of `spec`."""
    grid = onto.array
    signal = (counts - spec.electronics.offset) / spec.electronics.plateau
    rows = [_nearest(y, spec.array.y, spec.array.pitch[1]) for y in grid.y]
    columns = [_nearest(x, spec.array.x, spec.array.pitch[0]) for x in grid.x]
    out = np.zeros(grid.shape)
    for i, row in enumerate(rows):
        for j, column in enumerate(columns):
            if row is not None and column is not None:
                out[i, j] = signal[row, column]
    return out * onto.electronics.plateau + onto.electronics.offset


def _nearest(place: float, places: Floats, pitch: float) -> int | None:
    """The taxel under a place [mm] along one side; None beyond the outermost."""
    away = np.abs(places - place)
    return int(np.argmin(away)) if away.min() <= 0.5 * pitch else None
