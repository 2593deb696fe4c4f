"""Ends of tubes: flat faces that a turned one ends at, and that are not there about its axis.

No pad lies on a ring a few millimeters wide so that the face is felt all round its bore, as `gaps` asks.  But the
turned face tells the ring's outer circle, and what was felt of the ring lies between that and the bore's rim.
Where the middle was found free, a bore about the same axis is where to look (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from exploration.planning.open.known_face import KnownFace
from exploration.planning.open.round_rims import RoundRim, aside
from primitives.arrays import Floats
from primitives.shapes import Cylinder


@dataclass(frozen=True)
class RingEndsConfig:
    """When a flat face is the end of a tube."""

    upright: float = 0.998  # least cosine between the face's normal and the axis
    beyond: float = 3.0  # [mm] past the turned face, that what was felt of its end may seem to lie
    beside: float = 20.0  # [mm] from the end, within which the turned face was felt
    felt: int = 6  # touched places of the ring
    least: float = 2.5  # [mm] of the bore's radius
    largest: float = 60.0  # [mm] of the turned face's
    free: int = 4  # places inside, at which the face is not
    inside: float = 0.5  # [mm] nearer to the axis than all that was felt, where they are


def ring_ends(known: Sequence[KnownFace], config: RingEndsConfig = RingEndsConfig()) -> list[RoundRim]:
    """Circles where the bores of tubes may begin, with the outer circle of each ring."""
    found: list[RoundRim] = []
    barrels = [(own, shape) for own in known if (shape := _barrel(own, config)) is not None]
    for end in (own for own in known if own.fit.kind == "plane" and len(own.cells) >= config.felt):
        axis = end.side * end.fit.shape.direction
        for turned, shape in barrels:
            slope = float(axis @ shape.direction)
            if abs(slope) < config.upright or not _ends_at(turned, end, axis, config):
                continue
            along = float(axis @ (end.fit.shape.anchor - shape.anchor)) / slope
            center = shape.anchor + along * shape.direction
            felt, outer = aside(end.cells, center, axis), float(shape.radius)
            radius, outside = float(felt.min()), float(felt.max())
            inside = aside(end.free, center, axis) < radius - config.inside
            if config.least < radius and outside < outer + config.beyond and inside.sum() >= config.free:
                found.append(RoundRim(center, axis, radius, 1.0, end.face.id, outer=outer))
    return found


def _barrel(own: KnownFace, config: RingEndsConfig) -> Cylinder | None:
    shape = own.fit.shape
    if not isinstance(shape, Cylinder) or own.side < 0.0 or not len(own.cells):
        return None
    return shape if shape.radius < config.largest else None


def _ends_at(turned: KnownFace, end: KnownFace, axis: Floats, config: RingEndsConfig) -> bool:
    """Whether all that was felt of a turned face lies behind a flat one, and some of it near that."""
    behind = (end.fit.shape.anchor - turned.cells) @ axis
    return bool(behind.min() > -config.beyond and behind.min() < config.beside)
