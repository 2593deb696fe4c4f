"""Outlines drawn from pictures, put along the sides that a body has, and on them where they are that near.

Edges of a picture are off by a tenth of a millimeter and lean by a degree or two, and its corners are rounded by
the rubber.  An edge that leans no more than that off a straight side of the body runs along it, and lies on it if
it is near; where two such edges would meet after a short bend, they meet (our derivation).  So a slot's walls are
as parallel as its part's sides, and no slivers are left between what was measured and what was seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from models.meshing.flat_regions import Region
from primitives.arrays import Floats


@dataclass(frozen=True)
class SquaredConfig:
    """What is put straight."""

    side: float = 4.0  # [mm] of an edge of the body, from which it is a side of it
    edge: float = 2.0  # [mm] of an edge of the outline, from which it may run along one,
    lean: float = 0.15  # [rad] off it at most,
    ends: float = 0.35  # [mm] that its ends move at most,
    aside: float = 0.25  # [mm] and from a line, within which it lies on that
    round: float = 0.4  # [rad] by which edges of an arc turn at both ends, at most,
    alike: float = 0.4  # and of its length, that one beside it has at least
    bend: float = 2.0  # [mm] of what is left out at most where two of them meet
    off: float = 0.3  # [mm] that the outline may move in the mean


class Side(NamedTuple):
    """A straight line: all p with `across` . p = `offset`."""

    across: Floats  # (2,) unit
    offset: float  # [mm]


def sides_of(region: Region, config: SquaredConfig = SquaredConfig()) -> list[Side]:
    """The lines of a region's long edges."""
    found: list[Side] = []
    for rim in region.rims:
        along = np.roll(rim, -1, axis=0) - rim
        length = np.linalg.norm(along, axis=1)
        for k in np.flatnonzero(length > config.side):
            across = np.array([along[k, 1], -along[k, 0]]) / length[k]
            found.append(Side(across, float(across @ rim[k])))
    return found


def squared(part: Region, sides: Sequence[Side], config: SquaredConfig = SquaredConfig()) -> Region:
    """A region along the sides that its edges nearly run along; itself where that would change its shape."""
    if not sides:
        return part
    made = Region.of(_straight(rim, sides, config) for rim in part.rims)
    round_it = sum(float(np.linalg.norm(np.roll(rim, -1, axis=0) - rim, axis=1).sum()) for rim in part.rims)
    changed = (made - part).area + (part - made).area
    alike = bool(made) and len(made.pieces) == len(part.pieces) and len(made.rims) == len(part.rims)
    return made if alike and changed < config.off * round_it else part


def _straight(rim: Floats, sides: Sequence[Side], config: SquaredConfig) -> Floats:
    """(m, 2) corners of one closed rim of (n, 2)."""
    lines = _lines(rim, sides, config)  # of the edge that begins at each corner
    put = [(k, line) for k, line in enumerate(lines) if line is not None]
    if not put:
        return rim
    made: list[Floats] = []
    for (k, here), (ahead, there) in zip(put, [*put[1:], put[0]], strict=True):
        count = (ahead - k - 1) % len(rim) + 1  # of corners from the end of the one to the start of the other
        made += _joined(here, there, rim[(k + 1 + np.arange(count)) % len(rim)], config)
    return np.array(made)


def _lines(rim: Floats, sides: Sequence[Side], config: SquaredConfig) -> list[Side | None]:
    """The line that each edge of a rim is put on, if any; edges of an arc are on none."""
    after = np.roll(rim, -1, axis=0)
    along = after - rim
    length = np.linalg.norm(along, axis=1)
    ahead = np.roll(along, -1, axis=0)
    turn = np.arctan2(along[:, 0] * ahead[:, 1] - along[:, 1] * ahead[:, 0], (along * ahead).sum(axis=1))
    before = np.roll(turn, 1)  # at the corner where an edge begins
    bent = np.minimum(np.abs(turn), np.abs(before))
    beside = np.maximum(np.roll(length, 1), np.roll(length, -1))
    arc = (turn * before > 0.0) & (bent > 0.01) & (bent < config.round) & (beside > config.alike * length)
    within = arc & (np.maximum(np.abs(turn), np.abs(before)) < config.round)
    arc = within | arc & (np.roll(within, 1) | np.roll(within, -1))  # a side bent once is none
    lines = [
        None if round_it else _side(a, b, sides, config)
        for a, b, round_it in zip(rim, after, arc, strict=True)
    ]
    for k in range(len(lines)):  # what is one edge in two parts lies on one line
        here, there = lines[k - 1], lines[k]
        if here is not None and there is not None and float(here.across @ there.across) > 1.0 - 1e-9:
            longer = here if length[k - 1] > length[k] else there
            if abs(here.offset - there.offset) < config.aside:
                lines[k - 1] = lines[k] = longer
    return lines


def _joined(here: Side, there: Side, between: Floats, config: SquaredConfig) -> list[Floats]:
    """Corners from one side to the next: where they meet, or those that were between them."""
    cross = float(here.across[0] * there.across[1] - here.across[1] * there.across[0])
    if abs(cross) > config.lean:
        meet = np.linalg.solve(np.stack([here.across, there.across]), np.array([here.offset, there.offset]))
        meet = np.asarray(meet, dtype=np.float64)
        if float(np.linalg.norm(between - meet, axis=1).max()) < config.bend:
            return [meet]
    return [_onto(between[0], here), *between[1:-1], _onto(between[-1], there)]


def _onto(place: Floats, side: Side) -> Floats:
    return np.asarray(place + (side.offset - side.across @ place) * side.across)


def _side(start: Floats, end: Floats, sides: Sequence[Side], config: SquaredConfig) -> Side | None:
    """The line that an edge is put on: along the side it leans least off, on the nearest such if that is near."""
    along = end - start
    length = float(np.linalg.norm(along))
    if length < config.edge:
        return None
    across = np.array([along[1], -along[0]]) / length
    leans = [abs(float(across[0] * side.across[1] - across[1] * side.across[0])) for side in sides]
    least = min(leans)
    if least > config.lean or 0.5 * length * least > config.ends:
        return None
    middle = 0.5 * (start + end)
    best = sides[int(np.argmin(leans))].across
    best = best if best @ across > 0.0 else -best
    offset = float(best @ middle)
    alike = [
        side.offset * np.sign(side.across @ best) for side in sides if abs(side.across @ best) > 1.0 - 1e-5
    ]
    near = min(alike, key=lambda other: abs(other - offset))
    return Side(best, float(near) if abs(near - offset) < config.aside else offset)
