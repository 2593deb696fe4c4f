"""The taxels that feel nothing while the pad lies on the object: no surface rises past the skin over them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_dilation

from exploration.control.feel import Felt
from exploration.devices.guard import Observation
from primitives import pose as se3
from primitives.arrays import Floats


@dataclass(frozen=True)
class FreeCellsConfig:
    """What counts as untouched."""

    sigmas: float = 4.0  # of a taxel's noise, below which it may be untouched
    share: float = 0.12  # of the press, below which it is
    press: float = 0.3  # [mm] of the pad as a whole, from which its free taxels speak


def free_cells(seen: Observation, felt: Felt, config: FreeCellsConfig | None = None) -> Floats:
    """(n, 3) world places [mm] on the undented skin over untouched taxels; none where the press is light."""
    config = config or FreeCellsConfig()
    if felt.depth < config.press:
        return np.empty((0, 3))
    image = seen.image
    live = np.isfinite(image.sigma)
    low = np.maximum(config.share * felt.depth, config.sigmas * image.sigma)
    free = live & (image.depth < low) & ~binary_dilation(felt.mask)
    rows, columns = np.nonzero(free)
    local = np.column_stack([image.array.x[columns], image.array.y[rows], np.zeros(len(rows))])
    return se3.transform_points(seen.world_from_sensor, local)
