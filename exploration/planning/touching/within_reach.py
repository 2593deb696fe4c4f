"""Approaches that stay where the stage gets to, however large what they go round is taken for.

An object lies in the workspace, beyond which the stage reaches: an approach begins where its line comes in.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from exploration.planning.touching.lone_touch import Approach
from exploration.planning.ways.travel import EDGE
from primitives.arrays import Floats
from primitives.pose import pose


def begun_within(approach: Approach, reach: Floats) -> Approach:
    """The same line, begun where it enters a (6,) box [mm]; itself where it begins there or never enters it."""
    low, high = reach[:3] + EDGE, reach[3:] - EDGE
    at, way = approach.start[:3, 3], approach.direction
    away = np.where(at < low, low - at, np.where(at > high, high - at, 0.0))
    out = away != 0.0
    if not out.any() or (away[out] * way[out] <= 0.0).any():
        return approach
    late = float((away[out] / way[out]).max())
    begin = at + late * way
    if late >= approach.length or (begin < low - 1e-6).any() or (begin > high + 1e-6).any():
        return approach
    start = pose(approach.start[:3, :3], begin)
    return replace(
        approach, start=start, length=approach.length - late, flown=max(approach.flown - late, 0.0)
    )
