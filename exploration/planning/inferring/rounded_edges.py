"""Rounded edges between two walls that no array lay on, inferred from where contact with either wall ends.

A pad that lies on a flat wall loses it a little past the line where a rounding begins, where that has fallen away
by as much as the skin is pressed in, d.  With t the distance of that line from where the walls would meet and a
the angle between their normals, contact ends at

    t - sqrt(2 r d) = e,   t = r tan(a / 2)

from there.  Where both walls end as far from their common edge, or one does and the other was felt about as far
from it last, and nothing of either was felt much nearer, the edge is rounded, or cut off by a chamfer so small
that it was not felt (our derivation).  A wall that ends where a third one stands, or would if it went on that far,
as the side of a plate does under what hangs over it, tells of an edge with that.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from exploration.planning.touching.findings import SeenRim
from primitives.arrays import Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.shapes import Plane


@dataclass(frozen=True)
class RoundedEdgesConfig:
    """What is a rounded edge."""

    turns: tuple[float, float] = (0.5, 2.2)  # [rad] from one wall's normal to the other's
    ends: tuple[float, float] = (1.5, 8.0)  # [mm] from where the walls would meet
    flush: float = 1.0  # [mm] past a third wall, up to which one ends there
    toward: float = 0.97  # least cosine between a rim's way out and the straight way there
    alike: float = 0.15  # of the distances of both walls' ends, that they differ from each other at most
    least: int = 2  # rims of a wall, at so many places
    place: float = 1.0  # [mm] of the edge, that is one
    together: float = (
        12.0  # [mm] along the edge from a rim of one wall to one of the other, or to where it was felt,
    )
    nearer: float = 0.7  # of the distance of a rim, that no wall was felt nearer to the edge,
    short: float = 4.0  # [mm] and how much farther from it the other may have been felt last
    pressed: float = 0.24  # [mm] d
    arc: float = 0.4  # of the turn to either side of the middle, where contacts are laid
    count: int = 7  # of them, in each of so many
    rows: int = 3
    sigma: float = 0.3  # [mm]
    normal_sigma: float = 0.03  # [rad]


@dataclass(frozen=True)
class _Wall:
    """A flat wall, and the rims that were seen from it."""

    normal: Floats  # (3,) outward
    offset: float  # [mm]
    points: Floats  # (n, 3) of the rims
    outward: Floats  # (n, 3)
    felt: Floats  # (m, 3) where it was felt


def rounded_edges(
    rims: Sequence[SeenRim], faces: Sequence[Face], config: RoundedEdgesConfig = RoundedEdgesConfig()
) -> list[Contacts]:
    """Contacts of the rounding of each edge at which two walls end alike; nothing explains these `rims`."""
    found: list[Contacts] = []
    walls = list(_walls(rims, faces))
    for one, other in combinations(walls, 2):
        turn = float(np.arccos(np.clip(one.normal @ other.normal, -1.0, 1.0)))
        if config.turns[0] < turn < config.turns[1]:
            ends = _ended(one, other, walls, config)
            if len(ends):
                found.append(_laid(one, other, turn, ends, config))
    return found


def _walls(rims: Sequence[SeenRim], faces: Sequence[Face]) -> Iterator[_Wall]:
    for face in faces:
        if isinstance(face.fit, Fit) and isinstance(face.fit.shape, Plane):
            own = [rim for rim, number in rims if number == face.id]
            normal = face.fit.shape.direction * (1.0 if face.fit.convex else -1.0)
            points = np.array([rim.point for rim in own]).reshape(-1, 3)
            outward = np.array([rim.outward for rim in own]).reshape(-1, 3)
            felt = face.contacts.points[face.contacts.touch != NOT_FELT]
            if len(felt):
                yield _Wall(normal, float(face.fit.shape.anchor @ normal), points, outward, felt)


def _ended(one: _Wall, other: _Wall, walls: Sequence[_Wall], config: RoundedEdgesConfig) -> Floats:
    """(n, 2) [mm] along the common edge, and from it, of the rims that show it rounded; none where it is not."""
    own, elsewhere = _ends(one, other, walls, config)
    others, others_elsewhere = (ends * [-1.0, 1.0] for ends in _ends(other, one, walls, config))
    felt, felt_other = _from_edge(one, other, one.felt), _from_edge(other, one, other.felt) * [-1.0, 1.0]
    if _enough(own, config) and _enough(others, config):
        far = float(np.median(own[:, 1])), float(np.median(others[:, 1]))
        beside = np.abs(own[:, 0][:, None] - others[:, 0])
        ends = np.concatenate(
            [own[beside.min(axis=1) < config.together], others[beside.min(axis=0) < config.together]]
        )
        if not _enough(ends, config) or abs(far[0] - far[1]) > config.alike * max(far):
            return ends[:0]
        bare = all(_nearest(ends, places, config) > config.nearer * max(far) for places in (felt, felt_other))
        return ends if bare else ends[:0]
    sides = ((own, others_elsewhere, felt, felt_other), (others, elsewhere, felt_other, felt))
    for ends, against, mine, theirs in sides:
        if _enough(ends, config) and not len(_beside(ends, against, config)):
            last = config.nearer * float(np.median(ends[:, 1]))
            near, nearest = _nearest(ends, mine, config), _nearest(ends, theirs, config)
            if near > last and last < nearest < float(np.median(ends[:, 1])) + config.short:
                return ends
    return own[:0]


def _ends(
    own: _Wall, other: _Wall, walls: Sequence[_Wall], config: RoundedEdgesConfig
) -> tuple[Floats, Floats]:
    """(n, 2) [mm] along the common edge, and from it, of the rims of a wall that look straight to it first.

    And of those that look to a third wall first.
    """
    mine = _ahead(own, other, config.ends[0], config)
    thirds = [
        _ahead(own, wall, -config.flush, config) for wall in walls if wall is not own and wall is not other
    ]
    first = mine <= np.min([mine, *thirds], axis=0)
    places, looks = _from_edge(own, other, own.points), np.isfinite(mine)
    return places[looks & first], places[looks & ~first]


def _ahead(own: _Wall, other: _Wall, least: float, config: RoundedEdgesConfig) -> Floats:
    """(n,) [mm] from the rims of a wall straight to where another would meet it; inf where it does not."""
    across = other.normal - other.normal @ own.normal * own.normal
    slope = float(np.linalg.norm(across))
    if slope < np.sin(config.turns[0]):
        return np.full(len(own.points), np.inf)
    before = _from_edge(own, other, own.points)[:, 1]
    toward = own.outward @ (across / slope) > config.toward
    return np.where(toward & (before > least) & (before < config.ends[1]), before, np.inf)


def _from_edge(own: _Wall, other: _Wall, points: Floats) -> Floats:
    """(n, 2) [mm] along the common edge, and from it, of (n, 3) places of a wall."""
    along = np.cross(own.normal, other.normal)
    slope = float(np.linalg.norm(along))
    return np.column_stack([points @ (along / slope), (other.offset - points @ other.normal) / slope])


def _enough(ends: Floats, config: RoundedEdgesConfig) -> bool:
    return len(np.unique(np.round(ends[:, 0] / config.place))) >= config.least


def _nearest(ends: Floats, felt: Floats, config: RoundedEdgesConfig) -> float:
    """[mm] from the edge that a wall was felt nearest, beside some rims; inf where it was not."""
    return float(_beside(ends, felt, config)[:, 1].min(initial=np.inf))


def _beside(ends: Floats, places: Floats, config: RoundedEdgesConfig) -> Floats:
    """Those of (m, 2) places that are beside one of (n, 2) rims, along the edge."""
    return np.asarray(places[np.abs(ends[:, 0][:, None] - places[:, 0]).min(axis=0) < config.together])


def _laid(one: _Wall, other: _Wall, turn: float, ends: Floats, config: RoundedEdgesConfig) -> Contacts:
    """Contacts of the rounding, as far along the edge as rims were seen."""
    end, half = float(np.median(ends[:, 1])), np.tan(0.5 * turn)
    pressed = np.sqrt(2.0 * config.pressed)
    radius = float((pressed + np.sqrt(2.0 * config.pressed + 4.0 * half * end)) / (2.0 * half)) ** 2
    along = np.cross(one.normal, other.normal)
    along = along / np.linalg.norm(along)
    out = (one.normal + other.normal) / np.linalg.norm(one.normal + other.normal)
    corner = np.linalg.solve(np.stack([one.normal, other.normal, along]), [one.offset, other.offset, 0.0])
    center = corner - radius / np.cos(0.5 * turn) * out
    angles = np.linspace(-config.arc, config.arc, config.count) * turn
    ways = np.outer(np.cos(angles), out) + np.outer(np.sin(angles), np.cross(along, out))
    rows = np.linspace(ends[:, 0].min(), ends[:, 0].max(), config.rows)
    points = np.concatenate([center + radius * ways + row * along for row in rows])
    return Contacts.of(
        points, np.tile(ways, (config.rows, 1)), config.sigma, config.normal_sigma, touch=NOT_FELT
    )
