"""Keyways in shafts: slots along a cylinder, in which no array has room.

A pad that lies along a cylinder shows where its wall is and where it is not (`Mosaic.unrolled`).  Where the wall
is missing between two straight lines along the axis, that run as far as they are apart or more, and on past one
end of the cylinder at most, a slot with parallel sides was cut into it.  Its sides are where the lines are; its
end is taken for round, as an end mill leaves it, for under the skin a straight one looks alike.  How deep it is a
picture of the flat end tells through which it goes on.  Else it is taken for half as deep as wide, which is about
what a keyway is (DIN 6885), and marked as inferred like the rest (our derivation).

A flat, or a slot in which something was felt, is a face of its own, and none of this.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import label

from exploration.planning.known.mosaic import Lattice, Mosaic, Unrolled
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

    level: float = 0.5  # of the wall's own share, below which it is not there
    wall: float = 0.8  # quantile of all that is known, which is the wall's own share,
    least: float = 0.4  # that this is at least, of a wall that was pressed at all
    standing: float = (
        0.5  # share of a row that shows the wall, from which the cylinder is there at its height
    )
    wide: tuple[float, float] = (2.5, 1.2)  # [mm] at least, and of the cylinder's radius at most
    alike: float = 0.8  # [mm] that the width of a row may differ from the median one
    straight: float = 1.0  # widths, over which it is that wide at least
    rough: float = 0.35  # [mm] by which its sides may stray from lines along the axis
    open_end: float = 1.5  # [mm] from the end of the cylinder, where it goes on through that
    deep: float = 0.4  # [mm] under the wall, from which what is known in the gap is a face of its own,
    looks: float = -0.3  # with at least this cosine between its normal and the way out: no bore's inside,
    few: int = 3  # such contacts
    margin: float = 0.15  # of its width, that these lie within its sides and ends
    across: float = 0.25  # of its width to either side of its middle, where the picture tells its depth
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
        for sign in (1.0, -1.0):
            yield self._lot(along + sign * half * aside, raised, -sign * aside, config), "plane"
        yield self._lot(along + floor * self.out, across, self.out, config), "plane"
        turns = np.linspace(-config.arc, config.arc, config.places)
        for open_, middle, way in ((self.open_low, low, -up), (self.open_high, high, up)):
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
        up = (own.cells - shape.anchor) @ shape.direction
        seen = mosaic.unrolled(shape, float(up.min()) - 2.0, float(up.max()) + 2.0)
        for gap in _gaps(seen, shape, config):
            key = _of(gap, shape, faces, mosaic, config)
            if key is not None and not any(key.same(other) for other in found):
                found.append(key)
    return found


@dataclass(frozen=True)
class _Gap:
    """Where the wall is missing, all in one piece."""

    turn: float  # [rad] of its middle
    width: float  # [mm]
    low: float  # [mm]
    high: float
    open_low: bool
    open_high: bool


def _gaps(seen: Unrolled, shape: Cylinder, config: KeywaysConfig) -> Iterator[_Gap]:
    """Each with straight sides along the axis, between rows and columns that show the wall."""
    if not seen.known.any():
        return
    own = float(np.quantile(seen.share[seen.known], config.wall))
    if own < config.least:
        return
    level = config.level * own
    there = seen.known & (seen.share >= level)
    standing = np.flatnonzero(there.sum(axis=1) > config.standing * seen.known.sum(axis=1).clip(1))
    if len(standing) < 2:
        return
    seam = int(there.sum(axis=0).argmax())  # no gap lies across the column that shows most of the wall
    wall = seen.part(slice(standing[0], standing[-1] + 1), seam)
    pieces, count = label(wall.known & (wall.share < level))
    for number in range(1, count + 1):
        gap = _straight(pieces == number, wall, level, shape.radius, config)
        if gap is not None:
            yield replace(gap, turn=gap.turn + float(seen.turns[seam]))


def _straight(
    piece: Bools, wall: Unrolled, level: float, radius: float, config: KeywaysConfig
) -> _Gap | None:
    """A piece of what is missing, if its sides are straight; its turn is from the first column."""
    at, turns = _sides(piece, wall, level)
    if not len(at):
        return None
    widths = 2.0 * radius * np.sin(np.minimum(0.5 * (turns[:, 1] - turns[:, 0]), 0.5 * np.pi))
    like = np.abs(widths - np.median(widths)) < config.alike
    if not like.any():
        return None
    width, middle = float(np.median(widths[like])), float(turns[like].mean())
    length = float(like.sum()) * float(wall.heights[1] - wall.heights[0])
    stray = float(radius * turns[like].std(axis=0).max())
    if not config.wide[0] < width < config.wide[1] * radius:
        return None
    if length < config.straight * width or stray > config.rough:
        return None
    column = int(np.abs(wall.turns - middle).argmin())
    inside = np.flatnonzero(piece[:, column])
    if not len(inside):
        return None
    past, ends = [], []
    for row, way, last in ((int(inside[0]), -1, 0), (int(inside[-1]), 1, len(wall.heights) - 1)):
        past.append(abs(float(wall.heights[row] - wall.heights[last])) < config.open_end)
        if not past[-1] and not wall.known[row + way, column]:
            return None  # nobody looked where it ends
        ends.append(float(wall.heights[row]) if past[-1] else _end(wall, column, row, way, level))
    return None if all(past) else _Gap(middle, width, ends[0], ends[1], past[0], past[1])


def _sides(piece: Bools, wall: Unrolled, level: float) -> tuple[Floats, Floats]:
    """(n,) heights [mm] of rows with wall on both sides of a piece, and (n, 2) turns [rad] of its sides there."""
    heights, sides = [], []
    for row in np.flatnonzero(piece.any(axis=1)):
        columns = np.flatnonzero(piece[row])
        before, after = int(columns[0]) - 1, int(columns[-1]) + 1
        if before >= 0 and after < piece.shape[1] and wall.known[row, [before, after]].all():
            over = slice(before, after + 1)
            share, edge = wall.share[row, over], 2.0 * wall.edge[row, over]
            heights.append(wall.heights[row])
            left, right = share - (1.0 - edge) * level, share - (1.0 + edge) * level
            sides.append((before + _past(left), after - _past(right[::-1])))
    return np.array(heights), np.array(sides).reshape(-1, 2) * float(wall.turns[1])


def _past(over: Floats) -> float:
    """Of (n,) shares over what an edge has, from the wall into a gap: how many places on it falls under that."""
    inside = int((over < 0.0).argmax())
    if inside == 0:
        return 0.0 if over[0] < 0.0 else float(len(over) - 1)
    return float(inside - over[inside] / (over[inside] - over[inside - 1]))


def _end(wall: Unrolled, column: int, row: int, way: int, level: float) -> float:
    """[mm] the height at which a column passes the level, between the last row of a gap and the next."""
    inside, beyond = (float(wall.share[k, column]) for k in (row, row + way))
    past = float(np.clip((level - inside) / max(beyond - inside, 1e-9), 0.0, 1.0))
    return float(wall.heights[row] + past * (wall.heights[row + way] - wall.heights[row]))


def _of(
    gap: _Gap, shape: Cylinder, faces: Sequence[Face], mosaic: Mosaic, config: KeywaysConfig
) -> Keyway | None:
    """The keyway that a gap is, if no face is known in it."""
    out = np.asarray(shape.frame[:, :2] @ [np.cos(gap.turn), np.sin(gap.turn)])
    if any(_within(face, gap, shape, out, config) for face in faces):
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


def _within(face: Face, gap: _Gap, shape: Cylinder, out: Floats, config: KeywaysConfig) -> bool:
    """Whether contacts of a face lie in a gap, under the cylinder's wall and over what is behind any keyway."""
    away, deep = face.contacts.points - shape.anchor, -shape.signed_distance(face.contacts.points)
    up, across = away @ shape.direction, away @ np.cross(shape.direction, out)
    beside = config.margin * gap.width
    within = (up > gap.low + beside) & (up < gap.high - beside) & (away @ out > 0.0)
    within &= np.abs(across) < 0.5 * gap.width - beside
    within &= (deep > config.deep) & (deep < config.hollow[1] * gap.width)
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
    gap: _Gap, shape: Cylinder, out: Floats, end: Plane, way: Floats, mosaic: Mosaic, config: KeywaysConfig
) -> float | None:
    """[mm] how deep a gap is at its middle by a picture of the end; None where that does not show it."""
    aside = np.cross(shape.direction, out)
    corners = np.array([[x, y] for x in (-1.0, 1.0) for y in (0.0, 1.0)]) * [0.5 * gap.width, shape.radius]
    at = shape.anchor + corners @ np.array([aside, out])
    lattice = Lattice.over(at, np.column_stack([aside, out]), mosaic.config.step, 0.0)
    seen = mosaic.picture(end.anchor, way, lattice)
    columns = lattice.origin[0] + lattice.step * np.arange(lattice.shape[0]) - shape.anchor @ aside
    rows = lattice.origin[1] + lattice.step * np.arange(lattice.shape[1]) - shape.anchor @ out
    near = np.abs(columns) < config.across * gap.width
    known = seen.known[near].any(axis=0)
    share = np.where(seen.known[near], seen.share[near], 0.0).sum(axis=0) / np.maximum(
        seen.known[near].sum(axis=0), 1
    )
    for row in range(len(rows) - 1):
        if known[row] and known[row + 1] and share[row] >= config.level > share[row + 1]:
            past = (share[row] - config.level) / (share[row] - share[row + 1])
            deep = shape.radius - float(rows[row] + lattice.step * past)
            low, high = config.hollow
            return deep if low * gap.width < deep < high * gap.width else None
    return None
