"""Where the skin ran into something on its way, told by the frame in which a limit was passed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from exploration.control.feel import feel
from exploration.control.kept_contacts import touched_cells
from exploration.devices.guard import Fault
from primitives import pose as se3
from primitives.arrays import Floats

_MOVED = 0.01  # [mm] least way that tells where the skin came from


@dataclass(frozen=True)
class Bump:
    """A place that the skin was stopped at."""

    point: Floats  # (3,) [mm]
    way: Floats  # (3,) unit vector along which the skin came there
    pose: Floats  # (4, 4) world_from_sensor then


def bump_of(fault: Fault) -> Bump | None:
    """Where the skin was hit; None where it felt nothing, or did not move."""
    if fault.seen is None or not (felt := feel(fault.seen.image)):
        return None
    here = fault.seen.world_from_sensor
    at = touched_cells(fault.seen, felt).mean(axis=0)
    own = se3.transform_points(se3.inverse(here), at[None])
    for before in fault.came:
        way = at - se3.transform_points(before, own)[0]
        if (moved := float(np.linalg.norm(way))) > _MOVED:
            return Bump(at, way / moved, here)
    return None
