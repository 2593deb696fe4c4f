"""How the pad comes to where an approach has to be felt for: turned as little as may be, and in flight as far as
nothing can be in the way.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from exploration.planning.touching.lone_touch import Approach
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
    share: float = 0.01  # of what is known, that may lie nearer than it is flown to
    clear: float = 12.0  # [mm] before an object that may be there, from where on it is not,
    beside: float = 8.0  # [mm] and beside it


def flown(approach: Approach, known: Held, library: Library, pad: tuple[float, float],
          config: FlightConfig | None = None) -> Approach:  # fmt: skip
    """The same approach, flown until something that may be there lies before a pad of (x, y) size [mm]."""
    config = config or FlightConfig()
    if known.unknown > config.strange:
        return approach
    origin, way = approach.start[:3, 3], approach.direction
    wide = 0.5 * float(np.hypot(*pad)) + config.beside
    nearest = np.full(len(known), np.inf)
    for k, (name, solid) in enumerate(zip(known.names, known.solids, strict=True)):
        points = transform_points(solid.pose, library[name].samples.points) - origin
        along = points @ way
        aside = np.linalg.norm(points - along[:, None] * way, axis=1)
        nearest[k] = along.min(initial=np.inf, where=aside < wide)
    first = float(_first(nearest[None], known, config)[0])
    if not np.isfinite(first):
        return approach
    return replace(approach, flown=float(np.clip(first - config.clear, 0.0, approach.length)))


def foreseen_flight(depth: Floats, known: Held, config: FlightConfig | None = None) -> Floats:
    """(c,) [mm] about what approaches are flown whose (c, h) hypotheses lie `depth` [mm] ahead, or inf."""
    config = config or FlightConfig()
    if known.unknown > config.strange:
        return np.zeros(len(depth))
    first = _first(depth, known, config)
    return np.where(np.isfinite(first), np.maximum(first - 2.0 * config.clear, 0.0), 0.0)


def _first(depth: Floats, known: Held, config: FlightConfig) -> Floats:
    """(c,) [mm] beyond which all but a small share of (c, h) depths lies; inf where nothing is met."""
    order = np.argsort(depth, axis=1)
    before = np.cumsum(known.weights[order], axis=1) / known.weights.sum()
    row = np.minimum((before < config.share).sum(axis=1), depth.shape[1] - 1)
    return np.asarray(np.take_along_axis(depth, order, axis=1)[np.arange(len(depth)), row])
