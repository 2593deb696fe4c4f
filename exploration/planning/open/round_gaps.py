"""Gaps in round faces: where a hole runs across a shaft, through a tube's wall or into a ball.

Seen along the normal at its middle the mouth of a round hole that runs straight in is a circle, however the face
bends.  So the places about a gap are laid into the plane across that normal, and a gap in that plane is looked for
(`gaps`); the normal at the circle's center is better, and leads to a better circle (our derivation).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from exploration.planning.known.surface_map import clusters
from exploration.planning.open.gaps import GapsConfig, gaps
from exploration.planning.open.known_face import KnownFace
from exploration.planning.open.round_rims import RoundRim, aside
from primitives.arrays import Floats
from primitives.shapes import Cone, Cylinder


@dataclass(frozen=True)
class RoundGapsConfig:
    """What of a round face is looked at round a gap."""

    facing: float = 0.4  # least cosine to the normal at the gap's middle
    within: float = 30.0  # [mm] of it
    passes: int = 3  # each from the normal at the circle before
    inside: float = 0.8  # least share of a gap's free places in the circle: a keyway is round only at its end
    past: float = 2.0  # [mm] past it, that a bar was touched toward either end: blur lays places past an edge
    sigma: float = 0.3  # [mm] of the radius, which skin that spans a mouth makes unsure
    spans: float = 1.45  # [mm] that skin spans of a mouth before it finds it free, measured in simulation
    flat: GapsConfig = field(default_factory=GapsConfig)


def round_gaps(own: KnownFace, config: RoundGapsConfig = RoundGapsConfig()) -> list[RoundRim]:
    """The circles about the gaps of a convex round face, each seen along its own axis."""
    if own.fit.kind == "plane" or own.side < 0.0 or not len(own.cells) or not len(own.free):
        return []
    away = np.asarray(own.near.query(own.free)[0])
    bare, away = own.free[away > config.flat.clear], away[away > config.flat.clear]
    found: list[RoundRim] = []
    if not len(bare):
        return found
    for members in clusters(bare, config.flat.together):
        if members.sum() < config.flat.least:
            continue
        rows = np.flatnonzero(members)
        rim = _about(own, bare[rows], bare[rows[np.argmax(away[rows])]], config)
        found += [rim] if rim is not None else []
    return found


def _about(own: KnownFace, free: Floats, middle: Floats, config: RoundGapsConfig) -> RoundRim | None:
    """The circle about a gap of (n, 3) free places near to a (3,) middle; None where there is none."""
    rim = _seen_at(own, free, middle, config)
    for _ in range(1, config.passes):
        rim = None if rim is None else _seen_at(own, free, rim.center, config)
    if rim is None or np.mean(aside(free, rim.center, rim.axis) < rim.radius) < config.inside:
        return None
    return rim if _within(own, rim, config) else None


def _within(own: KnownFace, rim: RoundRim, config: RoundGapsConfig) -> bool:
    """Whether a bar or cone was felt past a circle toward both its ends: where it ends, it is missing, too."""
    if not isinstance(own.fit.shape, Cylinder | Cone):
        return True
    up, end = (own.cells - rim.center) @ own.fit.shape.direction, rim.radius + config.past
    return bool(up.min() < -end and up.max() > end)


def _seen_at(own: KnownFace, free: Floats, middle: Floats, config: RoundGapsConfig) -> RoundRim | None:
    """The circle nearest to a (3,) middle in the plane across the normal there."""
    shape = own.fit.shape
    middle = shape.project(middle[None])[0]
    axis = shape.normals(middle[None])[0]
    touched, missing = (
        places[
            (shape.normals(places) @ axis > config.facing)
            & (np.linalg.norm(places - middle, axis=1) < config.within)
        ]
        for places in (own.cells, free)
    )
    circles = gaps(touched, missing, axis, own.face.id, config.flat)
    if not circles:
        return None
    nearest = min(circles, key=lambda circle: float(np.linalg.norm(circle.center - middle)))
    away = [aside(places, nearest.center, axis) for places in (touched, missing)]
    radius = _parted(away[0], away[1], nearest.radius) + config.spans
    center = shape.project(nearest.center[None])[0]
    return replace(nearest, center=center, radius=radius, sigma=config.sigma, measured=True, bent=True)


def _parted(touched: Floats, free: Floats, about: float) -> float:
    """[mm] from the axis, that parts free places from touched ones with as few as may be on the wrong side."""
    cuts = np.arange(0.5 * about, 1.5 * about, 0.05)
    wrong = [(touched < cut).sum() + (free > cut).sum() for cut in cuts]
    return float(cuts[np.flatnonzero(np.equal(wrong, min(wrong)))].mean())
