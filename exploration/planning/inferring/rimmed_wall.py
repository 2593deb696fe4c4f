"""A wall as rims tell it: places on it and the way that it looks.

A wall is known beside its rims alone; what was seen of one edge several times is one rim, and what several rims
tell of one wall is one lot of contacts that nobody felt (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exploration.control.sighting import Sighting
from exploration.planning.touching.findings import SeenRim
from primitives.arrays import Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face

Wall = tuple[Floats, Floats]  # (n, 3) places [mm], and the (3,) way that it looks


@dataclass(frozen=True)
class RimmedWallConfig:
    """When rims are one, and walls, and where a wall is known."""

    beside: float = 6.0  # [mm] between places of a rim that are one
    alike: float = 0.85  # least cosine between the ways out of a rim, seen twice
    known: float = 0.998  # least cosine between the ways that walls look which are one
    same: float = 0.6  # [mm] between them
    rows: tuple[float, ...] = (0.5, 1.2, 2.5)  # [mm] from a rim, where its wall is
    aside: float = 2.5  # [mm] of the way straight across a gap, on which its face may be felt again,
    again: float = 2.0  # [mm] at least from its rim
    looks_back: float = 0.9  # least cosine between the ways out of its two rims on one face, reversed
    sigma: float = 0.1  # [mm]
    normal_sigma: float = 0.02  # [rad]


def each_once(rims: Sequence[SeenRim], config: RimmedWallConfig = RimmedWallConfig()) -> list[SeenRim]:
    """Each place of an edge once, as it was seen longest: several parts of a pad show it."""
    kept: list[SeenRim] = []
    for rim, face in sorted(rims, key=lambda seen: -seen[0].length):
        same = (
            other
            for other, own in kept
            if own == face
            and rim.outward @ other.outward > config.alike
            and abs(float((rim.point - other.point) @ other.outward)) < config.same
            and float(np.linalg.norm(rim.point - other.point)) < config.beside
        )
        if next(same, None) is None:
            kept.append((rim, face))
    return kept


def join(found: list[Wall], wall: Wall, config: RimmedWallConfig = RimmedWallConfig()) -> None:
    """Add a wall to those found, or to the one of them that it is."""
    for j, (places, known) in enumerate(found):
        if same_wall((places, known), wall, config.same):
            found[j] = (np.concatenate([places, wall[0]]), known)
            return
    found.append(wall)


def same_wall(
    first: Wall, second: Wall, within: float, config: RimmedWallConfig = RimmedWallConfig()
) -> bool:
    """Whether two walls look the same way, `within` mm of each other."""
    apart = abs(float((first[0].mean(axis=0) - second[0].mean(axis=0)) @ second[1]))
    return bool(first[1] @ second[1] > config.known and apart < within)


def contacts_of(walls: Sequence[Wall], config: RimmedWallConfig = RimmedWallConfig()) -> list[Contacts]:
    """Contacts of each wall, which nobody felt."""
    return [
        Contacts.of(p, np.broadcast_to(n, p.shape), config.sigma, config.normal_sigma, touch=NOT_FELT)
        for p, n in walls
    ]


def directions(faces: Sequence[Face]) -> list[Floats]:
    """(3,) of each flat face."""
    return [f.fit.shape.direction for f in faces if isinstance(f.fit, Fit) and f.fit.kind == "plane"]


def along(rim: Sighting) -> Floats:
    """(n, 3) places on a rim."""
    return np.asarray(rim.point + np.outer(np.linspace(-0.4, 0.4, 7), rim.tangent * rim.length))


def between(a: Floats, b: Floats, config: RimmedWallConfig = RimmedWallConfig()) -> Floats:
    """(m, 3) places on a wall, beside its rims: from (n, 3) places on one of them toward (n, 3) on another.

    Farther from both something may stand on the wall, or open into it.
    """
    straight = b if (b[-1] - b[0]) @ (a[-1] - a[0]) >= 0.0 else b[::-1]
    far = float(np.linalg.norm(straight - a, axis=1).mean())
    deep = np.minimum(np.array(config.rows) / max(far, 1e-6), 0.4)
    return np.concatenate([(1.0 - share) * a + share * straight for share in (*deep, *(1.0 - deep))])


def width_of_gap(
    seen: SeenRim,
    rims: Sequence[SeenRim],
    faces: Sequence[Face],
    config: RimmedWallConfig = RimmedWallConfig(),
) -> float:
    """[mm] from a rim to the nearest on its face that looks back at it, or to where the face was felt again.

    Endless where neither is.
    """
    rim, face = seen
    felt = next((f.contacts for f in faces if f.id == face), Contacts.of([]))
    away = felt.points[felt.touch != NOT_FELT] - rim.point
    ahead = away @ rim.outward
    beside = np.abs(away @ rim.tangent) < max(0.5 * rim.length, config.aside)
    across = [
        float((other.point - rim.point) @ rim.outward)
        for other, own in rims
        if own == face
        and float(other.outward @ rim.outward) < -config.looks_back
        and abs(float((other.point - rim.point) @ rim.tangent)) < 0.5 * (rim.length + other.length)
    ]
    across += ahead[beside & (ahead > config.again)].tolist()
    return min((gap for gap in across if gap > 0.0), default=np.inf)
