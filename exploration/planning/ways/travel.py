"""Poses that stay within the stage's travel: a way that would leave it goes along its border."""

from __future__ import annotations

import numpy as np

from primitives.arrays import Floats
from primitives.pose import pose

EDGE = 2.0  # [mm] that a moving stage may overshoot


def kept_within(world: Floats, reach: Floats) -> Floats:
    """A (4, 4) pose moved into a (6,) box [mm]: lower corner, upper corner."""
    return pose(world[:3, :3], np.clip(world[:3, 3], reach[:3] + EDGE, reach[3:] - EDGE))


def room_behind(world: Floats, reach: Floats) -> float:
    """[mm] that an array at a (4, 4) pose can go straight along its own back, within a (6,) box [mm]."""
    way = -world[:3, 2]
    border = np.where(way < 0.0, reach[:3] + EDGE, reach[3:] - EDGE)
    moving = np.abs(way) > 1e-9
    return float(max(0.0, ((border - world[:3, 3])[moving] / way[moving]).min()))
