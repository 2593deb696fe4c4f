"""How the pad comes to where an approach has to be felt for: turned as little as may be, and in flight as far as
nothing can be in the way.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from exploration.planning.lone_touch import Approach
from models.library import Library
from primitives.arrays import Floats
from primitives.pose import pose, transform_points
from recognition.matching.next_touch.held import Held

_QUARTERS = tuple(
    pose(np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]))
    for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))
)


def least_turned(approach: Approach, here: Floats) -> Approach:
    """The same approach by quarter turns about itself: the one that a pad at (4, 4) `here` turns least for."""
    turned = [approach.start @ quarter for quarter in _QUARTERS]
    return replace(approach, start=max(turned, key=lambda at: float((at[:3, :3] * here[:3, :3]).sum())))


@dataclass(frozen=True)
class FlightConfig:
    """Where the pad is flown, and not felt ahead with."""

    strange: float = 0.05  # probability of an unknown object, up to which what is empty is flown through
    clear: float = 15.0  # [mm] before and beside an object that may be there, from where on it is not


def flown(approach: Approach, known: Held, library: Library, pad: tuple[float, float],
          config: FlightConfig | None = None) -> Approach:  # fmt: skip
    """The same approach, flown until something that may be there lies before a pad of (x, y) size [mm]."""
    config = config or FlightConfig()
    if known.unknown > config.strange:
        return approach
    origin, way, nearest = approach.start[:3, 3], approach.direction, np.inf
    wide = 0.5 * float(np.hypot(*pad)) + config.clear
    for name, solid in zip(known.names, known.solids, strict=True):
        points = transform_points(solid.pose, library[name].samples.points) - origin
        along = points @ way
        aside = np.linalg.norm(points - along[:, None] * way, axis=1)
        nearest = min(nearest, float(along.min(initial=np.inf, where=aside < wide)))
    if not np.isfinite(nearest):
        return approach
    return replace(approach, flown=float(np.clip(nearest - config.clear, 0.0, approach.length)))


def foreseen_flight(nearest: Floats, known: Held, config: FlightConfig | None = None) -> Floats:
    """(c,) [mm] about what approaches are flown that meet something after (c,) `nearest` [mm]."""
    config = config or FlightConfig()
    if known.unknown > config.strange:
        return np.zeros(len(nearest))
    return np.where(np.isfinite(nearest), np.maximum(nearest - 2.0 * config.clear, 0.0), 0.0)
