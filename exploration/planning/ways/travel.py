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
    """[mm] that an array at a (4, 4) pose can go straight along its own back, within a (6,) box [mm].

    Past the part of it that is kept free for overshooting it may go on to the border itself.
    """
    way, at = -world[:3, 2], world[:3, 3]
    moving = np.abs(way) > 1e-9
    border, inner = (np.where(way < 0.0, reach[:3] + edge, reach[3:] - edge) for edge in (0.0, EDGE))
    to_border, to_inner = ((end - at)[moving] / way[moving] for end in (border, inner))
    return float(max(0.0, np.where(to_inner > 0.0, to_inner, to_border).min()))
