"""Ends of tubes: flat faces that a turned one ends at, and that are not there about its axis.

No pad lies on a ring a few millimeters wide so that the face is felt all round its bore, as `gaps` asks.  But the
turned face tells the ring's outer circle, and what was felt of the ring lies between that and the bore's rim.
Where the middle was found free, a bore about the same axis is where to look (our derivation).

A ring may be so narrow that nothing on it makes a face.  Then the turned face's own rim tells where the tube ends,
and the places that were found free there how wide its bore is at least.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from exploration.control.sighting import Sighting
from exploration.planning.open.known_face import KnownFace
from exploration.planning.open.round_rims import RoundRim, aside
from primitives.arcs import around
from primitives.arrays import Floats
from primitives.shapes import Cylinder


@dataclass(frozen=True)
class RingEndsConfig:
    """When a flat face is the end of a tube."""

    upright: float = 0.998  # least cosine between the face's normal and the axis
    beyond: float = 3.0  # [mm] past the turned face, that what was felt of its end may seem to lie
    one_side: float = 3.3  # [rad] round the axis, over which such places past it lie at most
    beside: float = 20.0  # [mm] from the end, within which the turned face was felt
    felt: int = 6  # touched places of the ring
    least: float = 2.5  # [mm] of the bore's radius
    largest: float = 60.0  # [mm] of the turned face's
    free: int = 4  # places inside, at which the face is not
    inside: float = 0.5  # [mm] nearer to the axis than all that was felt, where they are
    round: float = 0.1  # most cosine between the rim of a turned face and its axis
    along: float = 0.3  # least cosine between the way out at that rim and the axis
    past: float = (
        4.0  # [mm] past that rim, where the turned face was felt nowhere: blur lays cells past an edge
    )
    level: tuple[float, float] = (-4.0, 1.0)  # [mm] of free places from the end of a tube
    nearly: float = 0.9  # share of them that are nearer to the axis than its bore's rim is guessed


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
            outer, felt = float(shape.radius), aside(end.cells, center, axis)
            within, past = felt[felt < outer + config.beyond], end.cells[felt >= outer + config.beyond]
            if len(past) and _around(past, center, shape) > config.one_side:
                continue  # a flange; but a plate beside the barrel may end in the same plane
            if len(within) < config.felt or (radius := float(within.min())) <= config.least:
                continue
            inside = aside(end.free, center, axis) < radius - config.inside
            if radius < outer and inside.sum() >= config.free:
                found.append(RoundRim(center, axis, radius, 1.0, end.face.id, outer=outer))
    return found


def bare_ends(
    known: Sequence[KnownFace],
    rims: Sequence[tuple[Sighting, int]],
    free: Callable[[], Floats],
    config: RingEndsConfig = RingEndsConfig(),
) -> list[RoundRim]:
    """Circles where the bores of tubes may begin of whose ends only the outer rims were looked at.

    Each of the `rims` comes with the id of its face; nothing is at the (n, 3) places [mm] that `free` gives.
    """
    found: list[RoundRim] = []
    flat = [own for own in known if own.fit.kind == "plane" and len(own.cells) >= config.felt]
    for turned in known:
        if (shape := _barrel(turned, config)) is None:
            continue
        for axis in (shape.direction, -shape.direction):
            heights = [
                float((rim.point - shape.anchor) @ axis)
                for rim, own in rims
                if own == turned.face.id
                and abs(float(rim.tangent @ axis)) < config.round
                and float(rim.outward @ axis) > config.along
            ]
            if not heights:
                continue
            center = shape.anchor + max(heights) * axis
            felt_past = float(((turned.cells - center) @ axis).max()) > config.past
            known_end = any(_passes(end, center, axis, config) for end in flat)
            if felt_past or known_end:
                continue
            places = free()
            up, far = (places - center) @ axis, aside(places, center, axis)
            low, high = config.level
            within = far[(up > low) & (up < high) & (far < shape.radius - config.inside)]
            if (
                len(within) >= config.free
                and (radius := float(np.quantile(within, config.nearly))) > config.least
            ):
                found.append(RoundRim(center, axis, radius, 1.0, turned.face.id, outer=float(shape.radius)))
    return found


def _around(places: Floats, center: Floats, shape: Cylinder) -> float:
    """[rad] round a cylinder's axis, over which (n, 3) places lie."""
    local = (places - center) @ shape.frame
    return around(np.arctan2(local[:, 1], local[:, 0]))


def _passes(end: KnownFace, center: Floats, axis: Floats, config: RingEndsConfig) -> bool:
    """Whether a flat face that looks along an axis goes through a (3,) place on it."""
    looks = float(end.side * end.fit.shape.direction @ axis) > config.upright
    return looks and abs(float((end.fit.shape.anchor - center) @ axis)) < config.beyond


def _barrel(own: KnownFace, config: RingEndsConfig) -> Cylinder | None:
    shape = own.fit.shape
    if not isinstance(shape, Cylinder) or own.side < 0.0 or not len(own.cells):
        return None
    return shape if shape.radius < config.largest else None


def _ends_at(turned: KnownFace, end: KnownFace, axis: Floats, config: RingEndsConfig) -> bool:
    """Whether all that was felt of a turned face lies behind a flat one, and some of it near that."""
    behind = (end.fit.shape.anchor - turned.cells) @ axis
    return bool(behind.min() > -config.beyond and behind.min() < config.beside)
