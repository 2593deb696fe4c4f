"""A body held to the outlines of its plates: what both sides of a plate have is added, what neither has goes.

Of notches, gaps between teeth, sockets and holes of any shape, in which no array has room, nothing is there on
either side of a plate.  Where the body has material between the two, a prism takes it away, unless something was
felt there; where it has none and both sides were felt, a prism is added, unless an array passed through (our
derivation).  Of a step what is missing goes down to its floor, and so does what the body lacks beside that.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from models.csg import Cylinder, Prism
from models.meshing.flat_regions import Region, section
from primitives.arcs import arcs
from primitives.arrays import Floats
from primitives.errors import PalpateError
from primitives.plate import Plate
from primitives.pose import inverse, pose, transform_points
from recognition.assembly.made import FLUSH, Body, thinned
from recognition.assembly.piece import Piece
from recognition.assembly.squared import Side, sides_of, squared

_CORNERS = 64  # of what stands for a circle
OUTLINED = {
    "add": "a part of a plate that no faces close is added where its sides were seen to be",
    "subtract": "what no faces close is taken away where the sides of a plate were seen not to be",
}


@dataclass(frozen=True)
class OutlinedConfig:
    """What of an outline counts."""

    levels: tuple[float, ...] = (-0.4, -0.2, 0.0, 0.2, 0.4)  # of the thickness, at which the body is cut,
    skin: float = 0.3  # [mm] and that far inside both sides, or a tenth of it, as through a thin flange
    thick: float = 12.0  # [mm] of a plate, from which what reaches neither side is none of it
    narrow: float = 0.8  # [mm] half the width of what is an edge that lies a little off, and no piece
    least: float = 12.0  # [mm^2] of a piece
    loose: float = 0.4  # [mm] that an outline may lie off a round piece,
    most: float = 0.7  # share of what is amiss there, that the round piece mends,
    untold: float = 0.03  # and share of that, which may lie past it
    under: float = 0.5  # share of what is below an upper side, from which a body has ended there
    past: float = 0.5  # [mm] that what takes away reaches out of the plate
    near: float = 0.5  # [mm] from a part of a plate, within which a contact holds it
    film: float = 0.15  # [mm] half the width of what a cut leaves along a side of the body
    deep: float = 1.0  # [mm] from both sides, or a third of the thickness, where a contact is on neither
    inside: float = 0.8  # [mm] in a piece, from which a contact or a free place contradicts it
    ended: float = 1.2  # [mm] past where both sides end, from which a contact is no error of the outline
    apart: float = 2.0  # [mm] between contacts that are told apart
    each: float = 150.0  # [mm^2] of a piece, for each of which one contact in it may stray,
    strays: int = 3  # up to so many
    beside: float = 4.0  # [mm] round such a contact, where nothing is taken away
    unseen: float = 3.5  # [mm] of the radius of a hole over which no taxel may be free, which is not filled
    round_it: float = 0.5  # [mm] more, all round
    free: int = 2  # places that an array passed through, that an added piece may hold


def outlined(
    body: Body,
    plates: Sequence[Plate],
    free: Floats | None,
    felt: Floats,
    config: OutlinedConfig = OutlinedConfig(),
) -> Body:
    """A body with the outlines of its plates; (n, 3) places `felt` are on it, `free` ones hold nothing [mm]."""
    felt = thinned(felt, config.apart)
    nowhere = np.empty((0, 3)) if free is None else thinned(free, config.apart)
    bare = body
    for plate in plates:
        sides = sides_of(_between(bare, plate, config))
        for piece in [*_disks(body, plate, "add", nowhere, config)]:
            body = body.more(piece) or body
        for piece in [*_lacking(body, plate, nowhere, sides, config)]:
            body = body.more(piece) or body
        for piece in [*_disks(body, plate, "subtract", felt, config)]:
            body = body.less(piece) or body
        body = _less(body, [*_excess(body, plate, felt, sides, config)])
    return body


def _less(body: Body, pieces: Sequence[Piece]) -> Body:
    """Without all pieces, or where that tears it apart, without those that do not."""
    whole: Body | None = body
    for piece in pieces:
        whole = None if whole is None else whole.less(piece, torn=True)
    if whole is not None and whole.shells <= body.shells:
        return whole
    for piece in pieces:
        body = body.less(piece) or body
    return body


def _disks(
    body: Body, plate: Plate, operation: str, places: Floats, config: OutlinedConfig
) -> Iterator[Piece]:
    """Round pieces of a plate that the body lacks, or has too much, by the arcs of its outline.

    None holds (n, 3) `places`: free ones where it is added, felt ones where it is taken away.
    """
    adds = operation == "add"
    short = _under(body, plate, config) if adds and plate.lies else 0.0
    rims = plate.there if adds else plate.missing
    told = Region.of(rims).grown(config.loose)
    between = (_had if adds else _between)(body, plate, config)
    wrong = (Region.of(rims) - between if adds else Region.of(rims) & between).opened(config.narrow).pieces
    wrong = [part for part in wrong if part.area > config.least]

    def found(disk: Region) -> Floats:
        if adds:
            return _within(disk, places, plate, config)
        return _against(disk, places, plate, config)

    for arc in (arc for rim in rims for arc in arcs(rim)):
        disk = Region.disks(arc.center[None], arc.radius, _CORNERS)
        most = config.free if adds else 0
        if (
            any((part & disk).area > config.most * part.area for part in wrong if part & disk)
            and (disk - told).area < config.untold * disk.area
            and not (adds and (disk - told).opened(config.narrow))  # no bore in it is filled
            and len(found(disk)) <= most
        ):
            past = 0.0 if adds else config.past
            low, high = short - 0.5 * plate.thick - (not plate.step) * past, 0.5 * plate.thick + past
            placed = plate.pose @ pose(translation=[*arc.center, 0.5 * (low + high)])
            bar = Cylinder(arc.radius, high - low)
            yield Piece("cylinder", operation, bar, placed, None, ((None, None),), OUTLINED[operation])


def _lacking(
    body: Body, plate: Plate, free: Floats, sides: Sequence[Side], config: OutlinedConfig
) -> Iterator[Piece]:
    """What both sides of a plate have, and the body at no level between."""
    short = _under(body, plate, config) if plate.lies else 0.0
    between, beside = _had(body, plate, config), Region.of(plate.missing).grown(config.narrow)
    there = Region.of(plate.there) - _holes(body, plate, config)
    for part in (there - between).opened(config.narrow).pieces:
        within = _within(part, free, plate, config)
        stands = not plate.step or bool(part & beside)
        if part.area > config.least and len(within) <= config.free and stands:
            lapping = part.grown(config.narrow) & (there | between)  # on to the body beside it
            yield from _prisms(squared(lapping, sides), "add", plate, -short)


def _had(body: Body, plate: Plate, config: OutlinedConfig) -> Region:
    """Where a body has what a plate has: at some level; at the top of a step, under whose edge may be a hollow."""
    if not plate.step:
        return _between(body, plate, config)
    return _section(body, plate, _heights(plate, config)[-1])


def _under(body: Body, plate: Plate, config: OutlinedConfig) -> float:
    """[mm] over the table that a body ends, below what was seen of its upper side."""
    there, seen = Region.of(plate.there), 0.0
    for height in sorted(_heights(plate, config), reverse=True):
        own = (_section(body, plate, height) & there).area
        if own < config.under * seen:
            return height + 0.5 * plate.thick
        seen = max(seen, own)
    return 0.0


def _excess(
    body: Body, plate: Plate, felt: Floats, sides: Sequence[Side], config: OutlinedConfig
) -> Iterator[Piece]:
    """What neither side of a plate has, and the body at some level between; of a thick one, up to a side.

    A post that stands on the rim of a thick plate is narrower than that, and neither side shows it.
    """
    between, gone = _between(body, plate, config), Region()
    at_sides = between if plate.thick < config.thick else _at_sides(body, plate, config)
    missing = Region.of(plate.missing) - Region.of(plate.there)  # of a thin ring a soft picture shows neither
    for part in (between & missing).opened(config.narrow).pieces:
        if not (part & at_sides).opened(config.narrow):
            continue
        strays = _against(part, felt, plate, config)
        if part.area > config.least and len(strays) <= min(config.strays, part.area / config.each):
            gone |= part - Region.disks(strays, config.beside)
    if gone:
        gone |= _cut_loose(between, gone, plate, felt, config)
    for part in gone.opened(config.narrow).pieces:
        if part.area > config.least:
            past = _past(part, body, plate, felt, config)
            yield from _prisms(squared(part, sides), "subtract", plate, *past)


def _past(
    part: Region, body: Body, plate: Plate, felt: Floats, config: OutlinedConfig
) -> tuple[float, float]:
    """[mm] below and above the plate that a part of it goes on to: out of the body, if nothing was felt there.

    The floor of a step ends it.
    """
    own = transform_points(inverse(plate.pose), felt)
    over = own[part.depth(own[:, :2]) > -config.inside, 2]
    ends = transform_points(inverse(plate.pose), body.solid.vertices)[:, 2]
    half = 0.5 * plate.thick
    below, above = (
        config.past if (side > half + config.deep).any() else max(config.past, config.past - half + end)
        for side, end in ((-over, -float(ends.min())), (over, float(ends.max())))
    )
    return (0.0 if plate.step else below), above


def _cut_loose(between: Region, gone: Region, plate: Plate, felt: Floats, config: OutlinedConfig) -> Region:
    """What a cut leaves hanging in the air, as beyond where anybody looked: nothing was felt on it.

    Nor does a film along a side that the cut comes close to hold anything.
    """
    own = transform_points(inverse(plate.pose), felt)
    own = own[np.abs(own[:, 2]) < 0.5 * plate.thick + config.deep, :2]
    loose = Region()
    for whole in between.pieces:
        left = whole - gone
        firm = left.opened(config.film)
        loose |= left - firm
        for part in sorted(firm.pieces, key=lambda part: part.area)[:-1]:
            if not part.opened(config.narrow) or not (part.depth(own) > -config.near).any():
                loose |= part
    return loose


def _holes(body: Body, plate: Plate, config: OutlinedConfig) -> Region:
    """Narrow round holes that the body has through a plate by surfaces of its own."""
    holes = Region()
    for piece in body.pieces:
        if isinstance(piece.solid, Cylinder) and piece.operation == "subtract" and piece.body is not None:
            placed = inverse(plate.pose) @ piece.world_from_piece
            if piece.solid.radius < config.unseen and abs(float(placed[2, 2])) > FLUSH:
                holes |= Region.disks(placed[None, :2, 3], piece.solid.radius + config.round_it, _CORNERS)
    return holes


def _between(body: Body, plate: Plate, config: OutlinedConfig) -> Region:
    """Where the body is, at any level between the two sides."""
    whole = Region()
    for height in _heights(plate, config):
        whole |= _section(body, plate, height)
    return whole


def _at_sides(body: Body, plate: Plate, config: OutlinedConfig) -> Region:
    """Where the body is just inside either side."""
    heights = _heights(plate, config)
    return _section(body, plate, heights[0]) | _section(body, plate, heights[-1])


def _heights(plate: Plate, config: OutlinedConfig) -> list[float]:
    """[mm] over the middle of a plate, at which the body is cut."""
    last = 0.5 * plate.thick - min(config.skin, 0.1 * plate.thick)
    return [-last, *(level * plate.thick for level in config.levels), last]


def _section(body: Body, plate: Plate, height: float) -> Region:
    """Of a body, so many mm over the middle of a plate."""
    return section(body.solid.body.mesh, plate.pose @ pose(translation=[0.0, 0.0, height]))


def _against(part: Region, felt: Floats, plate: Plate, config: OutlinedConfig) -> Floats:
    """(k, 2) those of (n, 3) felt places that say a part is there: on it, well past where its sides end."""
    own = _middle(felt, plate, config)
    own = own[part.depth(own) > -config.inside]
    return np.asarray(own[Region.of(plate.missing).depth(own) > config.ended])


def _within(part: Region, places: Floats, plate: Plate, config: OutlinedConfig) -> Floats:
    """(k, 2) those of (n, 3) places that lie well inside a part of a plate."""
    own = _middle(places, plate, config)
    return np.asarray(own[part.depth(own) > config.inside])


def _middle(places: Floats, plate: Plate, config: OutlinedConfig) -> Floats:
    """(k, 2) those of (n, 3) places that lie between the two sides of a plate and on neither."""
    own = transform_points(inverse(plate.pose), places)
    deep = min(config.deep, plate.thick / 3.0)
    return np.asarray(own[np.abs(own[:, 2]) < 0.5 * plate.thick - deep, :2])


def _prisms(
    part: Region, operation: str, plate: Plate, below: float = 0.0, above: float = 0.0
) -> Iterator[Piece]:
    """A part of a plate, and so many mm below and above it."""
    middle = plate.pose @ pose(translation=[0.0, 0.0, 0.5 * (above - below)])
    for corners in part.polygons:
        try:
            solid = Prism(tuple((float(x), float(y)) for x, y in corners), plate.thick + below + above)
        except PalpateError:
            continue
        open_ends = ((None, None), (None, None), (None, None))
        yield Piece("prism", operation, solid, middle, None, open_ends, OUTLINED[operation])
