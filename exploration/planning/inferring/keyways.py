"""Keyways in shafts: slots along a cylinder, in which no array has room.

Where the wall of a shaft is missing between two straight lines along its axis, that run as far as they are apart
or more, and on past one end at most (`wall_gaps`), a slot with parallel sides was cut into it.  Its sides are
where the lines are; its end is taken for round, as an end mill leaves it, for under the skin a straight one looks
alike.  How deep it is a picture of the flat end tells through which it goes on.  Else it is taken for half as deep
as wide, which is about what a keyway is (DIN 6885), and marked as inferred like the rest (our derivation).

A flat, or a slot in which something was felt, is a face of its own, and none of this.  A pad that lay across it
and sagged in may have read the shaft there: what lies no deeper than skin came and felt nothing was not felt.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from exploration.planning.inferring.wall_gaps import WallGap, wall_gaps
from exploration.planning.known.mosaic import Mosaic
from exploration.planning.known.picture_lines import begins, share_at
from exploration.planning.open.known_face import KnownFace
from primitives.arrays import Bools, Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.shapes import Cylinder, Plane

_UPRIGHT = 0.999  # least cosine between an end's normal and the axis
_NEAR = 2.0  # [mm] from where the cylinder was seen to end
_BESIDE = 5.0  # [mm] outside the cylinder, within which an end or a shoulder of it was felt


@dataclass(frozen=True)
class KeywaysConfig:
    """What is a keyway, and where its contacts are."""

    bare: float = 3.5  # [rad] round a shaft, over which it was felt nowhere, at most
    deep: float = 0.4  # [mm] under the wall, from which what is known in the gap is a face of its own,
    looks: float = -0.3  # with at least this cosine between its normal and the way out: no bore's inside,
    few: int = 3  # such contacts
    air: float = 0.1  # [mm] less deep than skin came and felt nothing, that a place is in the air
    margin: float = 0.15  # of its width, that these lie within its sides and ends
    across: float = 0.25  # of its width to either side of its middle, where the picture tells its depth
    lines: int = 5  # on so many lines
    hollow: tuple[float, float] = (0.2, 1.2)  # of its width, that it may be deep by what the picture shows
    places: int = 5  # contacts along each of its walls, and down
    arc: float = 1.2  # [rad] to either side of the middle of a round end, where its contacts are
    sigma: float = 0.3  # [mm]
    normal_sigma: float = 0.03  # [rad]


@dataclass(frozen=True)
class Keyway:
    """A slot along a convex cylinder."""

    shaft: Cylinder
    out: Floats  # (3,) from the axis through its middle
    low: float  # [mm] heights along it, where it ends or the cylinder does
    high: float
    width: float  # [mm]
    depth: float  # [mm] under the cylinder, at its middle
    seen: bool  # whether that was, in a picture of the end
    open_low: bool  # whether it goes on through the cylinder's ends
    open_high: bool

    @property
    def told(self) -> str:
        """What a person should know of each of its walls."""
        if self.seen:
            return "a wall of a keyway is inferred from where its shaft and the end of that are not"
        return (
            "a wall of a keyway is inferred from where its shaft is not; it is taken for half as deep as wide"
        )

    def same(self, other: Keyway) -> bool:
        """Whether both are of one slot, seen of two faces of one cylinder."""
        middles = [
            key.shaft.anchor + 0.5 * (key.low + key.high) * key.shaft.direction + key.shaft.radius * key.out
            for key in (self, other)
        ]
        return float(np.linalg.norm(middles[1] - middles[0])) < 0.5 * max(self.width, other.width)

    def walls(self, config: KeywaysConfig = KeywaysConfig()) -> Iterator[tuple[Contacts, str]]:
        """Contacts of its sides, floor and round ends, and what kind each is of; nobody felt them."""
        up, half, shape = self.shaft.direction, 0.5 * self.width, self.shaft
        aside, floor = np.cross(up, self.out), shape.radius - self.depth
        low = self.low + (0.0 if self.open_low else half)
        high = self.high - (0.0 if self.open_high else half)
        spread = np.linspace(0.1, 0.9, config.places)
        along = np.outer(low + spread * (high - low), up)
        raised = np.outer(floor + spread * (np.sqrt(shape.radius**2 - half**2) - floor), self.out)
        across = np.outer(half * (2.0 * spread - 1.0), aside)
        ends = ((self.open_low, low, -up), (self.open_high, high, up))
        inward = [np.outer(middle, up) + 0.5 * half * way for open_, middle, way in ends if not open_]
        floors = np.concatenate([along, *inward])  # under the round ends, too
        for sign in (1.0, -1.0):
            yield self._lot(along + sign * half * aside, raised, -sign * aside, config), "plane"
        yield self._lot(floors + floor * self.out, 0.8 * across, self.out, config), "plane"
        turns = np.linspace(-config.arc, config.arc, config.places)
        for open_, middle, way in ends:
            if not open_:
                to_end = np.outer(np.cos(turns), way) + np.outer(np.sin(turns), aside)
                yield self._lot(middle * up + half * to_end, raised, -to_end, config), "cylinder"

    def _lot(self, places: Floats, offsets: Floats, normals: Floats, config: KeywaysConfig) -> Contacts:
        """At each of (n, 3) places, whose normals those are, moved by each of (m, 3) offsets."""
        at = self.shaft.anchor + (places[:, None] + offsets).reshape(-1, 3)
        facing = np.repeat(np.broadcast_to(normals, places.shape), len(offsets), axis=0)
        return Contacts.of(at, facing, config.sigma, config.normal_sigma, touch=NOT_FELT)


def keyways(
    known: Sequence[KnownFace], faces: Sequence[Face], mosaic: Mosaic, config: KeywaysConfig = KeywaysConfig()
) -> list[Keyway]:
    """Those of all known cylinders, but where a face is known that may be its own."""
    found: list[Keyway] = []
    for own in known:
        shape = own.fit.shape
        if not isinstance(shape, Cylinder) or own.side < 0.0 or not len(own.cells):
            continue
        if _bare(own.cells, shape) > config.bare:
            continue  # as the rounding of an edge
        up = (own.cells - shape.anchor) @ shape.direction
        seen = mosaic.unrolled(shape, float(up.min()) - 2.0, float(up.max()) + 2.0)
        for gap in wall_gaps(seen, shape.radius):
            over = _amidst(gap, shape, config)
            air = mosaic.bare(shape, over) - config.air
            felt = own.cells[over(own.cells)]
            if (-shape.signed_distance(felt) > air).sum() >= config.few:
                continue  # as on a facet of it
            key = _of(gap, shape, air, faces, mosaic, config)
            if key is not None and not any(key.same(other) for other in found):
                found.append(key)
    return found


def _of(
    gap: WallGap,
    shape: Cylinder,
    air: float,
    faces: Sequence[Face],
    mosaic: Mosaic,
    config: KeywaysConfig,
) -> Keyway | None:
    """The keyway that a gap is, if no face is known in it, deeper than `air` [mm]."""
    out = np.asarray(shape.frame[:, :2] @ [np.cos(gap.turn), np.sin(gap.turn)])
    least = max(config.deep, air)
    if any(_within(face, gap, shape, out, least, config) for face in faces):
        return None
    low, high = gap.low, gap.high
    depth: float | None = None
    for open_, height, way in ((gap.open_low, low, -shape.direction), (gap.open_high, high, shape.direction)):
        ends = [] if not open_ else _flats(faces, shape, height)
        if any(float(normal @ way) < 0.0 for _, normal in ends):
            return None  # a shoulder stands there
        for end, _ in ends[:1]:
            level = float((end.anchor - shape.anchor) @ shape.direction)
            low, high = (level, high) if way @ shape.direction < 0 else (low, level)
            depth = _depth(gap, shape, out, end, way, mosaic, config)
    told = depth or 0.5 * gap.width
    return Keyway(shape, out, low, high, gap.width, told, depth is not None, gap.open_low, gap.open_high)


def _bare(places: Floats, shape: Cylinder) -> float:
    """[rad] the widest turn round a cylinder without any of (n, 3) places."""
    flat = (places - shape.anchor) @ shape.frame[:, :2]
    turns = np.sort(np.arctan2(flat[:, 1], flat[:, 0]))
    return float(np.diff(turns, append=turns[0] + 2.0 * np.pi).max())


def _amidst(gap: WallGap, shape: Cylinder, config: KeywaysConfig) -> Callable[[Floats], Bools]:
    """Whether (n, 3) places lie over the middle of a gap."""
    out = shape.frame[:, :2] @ [np.cos(gap.turn), np.sin(gap.turn)]

    def over(places: Floats) -> Bools:
        away = places - shape.anchor
        up, across = away @ shape.direction, away @ np.cross(shape.direction, out)
        along = (up > gap.low + gap.width) & (up < gap.high - gap.width) & (away @ out > 0.0)
        return np.asarray(along & (np.abs(across) < config.across * gap.width))

    return over


def _within(
    face: Face, gap: WallGap, shape: Cylinder, out: Floats, least: float, config: KeywaysConfig
) -> bool:
    """Whether contacts of a face lie in a gap, so deep under its wall [mm] and over what is behind any keyway."""
    away, deep = face.contacts.points - shape.anchor, -shape.signed_distance(face.contacts.points)
    up, across = away @ shape.direction, away @ np.cross(shape.direction, out)
    beside = config.margin * gap.width
    within = (up > gap.low + beside) & (up < gap.high - beside) & (away @ out > 0.0)
    within &= np.abs(across) < 0.5 * gap.width - beside
    within &= (deep > least) & (deep < config.hollow[1] * gap.width)
    return int((within & (face.contacts.normals @ out > config.looks)).sum()) >= config.few


def _flats(faces: Sequence[Face], shape: Cylinder, height: float) -> list[tuple[Plane, Floats]]:
    """Flat faces upright on a cylinder's axis near a height [mm] and beside it, and (3,) the way each looks."""
    ends: list[tuple[float, Plane, Floats]] = []
    for face in faces:
        plane = face.fit.shape if isinstance(face.fit, Fit) else None
        if isinstance(plane, Plane) and abs(float(plane.direction @ shape.direction)) > _UPRIGHT:
            away = abs(float((plane.anchor - shape.anchor) @ shape.direction) - height)
            beside = float(shape.signed_distance(face.contacts.points).min(initial=np.inf))
            if away < _NEAR and beside < _BESIDE:
                ends.append((away, plane, face.contacts.normals.mean(axis=0)))
    return [(plane, normal) for _, plane, normal in sorted(ends, key=lambda end: end[0])]


def _depth(
    gap: WallGap, shape: Cylinder, out: Floats, end: Plane, way: Floats, mosaic: Mosaic, config: KeywaysConfig
) -> float | None:
    """[mm] how deep a gap is at its middle by a picture of the end; None where that does not show it."""
    aside, (least, most) = np.cross(shape.direction, out), config.hollow
    deep = np.arange(0.0, most * gap.width, mosaic.config.step)
    beside = np.linspace(-config.across, config.across, config.lines) * gap.width
    center = shape.anchor + ((end.anchor - shape.anchor) @ shape.direction) * shape.direction
    places = center + np.multiply.outer(shape.radius - deep, out)[:, None] + np.outer(beside, aside)
    shares = share_at(mosaic, way, places, np.column_stack([aside, out]))
    found = [floor for line in shares.T if (floor := begins(deep, line)) is not None]
    told = float(np.median(found)) if len(found) > config.lines // 2 else 0.0
    return told if told > least * gap.width else None
