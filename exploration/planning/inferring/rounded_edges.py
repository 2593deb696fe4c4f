"""Rounded edges between two walls that no array lay on, inferred from where contact with either wall ends.

A pad that lies on a flat wall loses it a little past the line where a rounding begins, where that has fallen away
by as much as the skin is pressed in, d.  With t the distance of that line from where the walls would meet and a
the angle between their normals, contact ends at

    t - sqrt(2 r d) = e,   t = r tan(a / 2)

from there.  Where both walls end as far from their common edge, or one does and nothing of the other was felt
nearer to it, the edge is rounded, or cut off by a chamfer so small that it was not felt, whose volume is nearly
the same (our derivation).
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
    ends: tuple[float, float] = (1.5, 12.0)  # [mm] from where the walls would meet
    toward: float = 0.97  # least cosine between a rim's way out and the straight way there
    alike: float = 0.15  # of the distances of both walls' ends, that they differ from each other at most
    least: int = 2  # rims of a wall
    together: float = (
        12.0  # [mm] along the edge from a rim of one wall to one of the other, or to where it was felt,
    )
    nearer: float = 0.7  # of the distance of a rim, that the other wall was not felt nearer to the edge,
    short: float = 8.0  # [mm] and how much farther from it it may have been felt last
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
    for one, other in combinations(_walls(rims, faces), 2):
        turn = float(np.arccos(np.clip(one.normal @ other.normal, -1.0, 1.0)))
        if config.turns[0] < turn < config.turns[1]:
            ends, others = _ends(one, other, config), _ends(other, one, config)
            if _alike(one, other, ends, others, config):
                found.append(_laid(one, other, turn, ends, others, config))
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


def _ends(own: _Wall, other: _Wall, config: RoundedEdgesConfig) -> Floats:
    """(n, 2) [mm] along the common edge, and from it, of the rims of a wall that look straight to it."""
    across = other.normal - other.normal @ own.normal * own.normal
    toward = own.outward @ (across / np.linalg.norm(across)) > config.toward
    places = _from_edge(own, other, own.points)
    near = toward & (places[:, 1] > config.ends[0]) & (places[:, 1] < config.ends[1])
    return places[near]


def _from_edge(own: _Wall, other: _Wall, points: Floats) -> Floats:
    """(n, 2) [mm] along the common edge, and from it, of (n, 3) places of a wall."""
    along = np.cross(own.normal, other.normal)
    slope = float(np.linalg.norm(along))
    return np.column_stack([points @ (along / slope), (other.offset - points @ other.normal) / slope])


def _alike(one: _Wall, other: _Wall, ends: Floats, others: Floats, config: RoundedEdgesConfig) -> bool:
    """Whether two walls end as far from their common edge, beside each other."""
    if min(len(ends), len(others)) >= config.least:
        apart = np.abs(ends[:, 0][:, None] + others[:, 0]).min()
        far = float(np.median(ends[:, 1])), float(np.median(others[:, 1]))
        return bool(apart < config.together and abs(far[0] - far[1]) < config.alike * max(far))
    if len(ends) >= config.least:
        return _stays_behind(ends, _from_edge(other, one, other.felt), config)
    return len(others) >= config.least and _stays_behind(others, _from_edge(one, other, one.felt), config)


def _stays_behind(ends: Floats, felt: Floats, config: RoundedEdgesConfig) -> bool:
    """Whether a wall was felt beside the rims of another, and about as far from the edge as those are."""
    far, beside = float(np.median(ends[:, 1])), np.abs(ends[:, 0][:, None] + felt[:, 0]).min(axis=0)
    nearest = float(felt[beside < config.together, 1].min(initial=np.inf))
    return config.nearer * far < nearest < far + config.short


def _laid(
    one: _Wall, other: _Wall, turn: float, ends: Floats, others: Floats, config: RoundedEdgesConfig
) -> Contacts:
    """Contacts of the rounding, as far along the edge as rims were seen."""
    end, half = float(np.median(np.concatenate([ends[:, 1], others[:, 1]]))), np.tan(0.5 * turn)
    pressed = np.sqrt(2.0 * config.pressed)
    radius = float((pressed + np.sqrt(2.0 * config.pressed + 4.0 * half * end)) / (2.0 * half)) ** 2
    along = np.cross(one.normal, other.normal)
    along = along / np.linalg.norm(along)
    out = (one.normal + other.normal) / np.linalg.norm(one.normal + other.normal)
    corner = np.linalg.solve(np.stack([one.normal, other.normal, along]), [one.offset, other.offset, 0.0])
    center = corner - radius / np.cos(0.5 * turn) * out
    angles = np.linspace(-config.arc, config.arc, config.count) * turn
    ways = np.outer(np.cos(angles), out) + np.outer(np.sin(angles), np.cross(along, out))
    places = np.concatenate([ends[:, 0], -others[:, 0]])
    rows = np.linspace(places.min(), places.max(), config.rows)
    points = np.concatenate([center + radius * ways + row * along for row in rows])
    return Contacts.of(
        points, np.tile(ways, (config.rows, 1)), config.sigma, config.normal_sigma, touch=NOT_FELT
    )
