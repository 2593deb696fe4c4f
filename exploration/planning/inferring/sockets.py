"""Sockets with equal sides, hexagonal or square, that no array has room to face: from edges seen at their mouth.

Along each side, with o the way out of the face there, into the socket, an edge through p obeys

    o . p = o . c - a,

which is linear in the center c and half the width across flats a.  It is a socket where the ways out of nearly all
edges seen about one center are whole turns of 1/6 or 1/4 apart, and most sides were seen: edges of a round mouth
lie all round it.  That the sides go straight down is likely and not measured, and a side that was not seen is like
those that were (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exploration.planning.inferring.upright_walls import depth_below
from exploration.planning.touching.findings import SeenRim
from primitives.arrays import Bools, Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.pose import frame_along
from primitives.shapes import Plane


@dataclass(frozen=True)
class SocketsConfig:
    """When edges are of one socket."""

    sides: tuple[int, ...] = (6, 4)
    unseen: int = 1  # sides that may be
    turned: float = 0.08  # [rad] between the way out of an edge and that of its side
    off: float = 0.5  # [mm] of an edge from its side
    share: float = 0.7  # of the edges about the center, that must be of a side
    within: float = 1.0  # of a side's length, that an edge of it lies along
    beyond: float = 2.5  # [mm] outside the sides, up to which edges are about the center
    inside: tuple[float, float] = (
        2.0,
        15.0,
    )  # [mm] half the width across flats: in wider ones an array has room
    along: float = 0.35  # of a side's length, either way from its middle, where its contacts are
    rows: tuple[float, ...] = (0.2, 0.5, 0.8)  # of the depth, likewise
    sigma: float = 0.1  # [mm]
    normal_sigma: float = 0.02  # [rad]


@dataclass(frozen=True)
class _Mouth:
    """Of a socket, in its face's plane."""

    center: Floats  # (2,) [mm]
    inside: float  # [mm] half the width across flats
    ways: Floats  # (sides, 2) from each side to the center


def sockets(
    rims: Sequence[SeenRim], faces: Sequence[Face], config: SocketsConfig = SocketsConfig()
) -> list[Contacts]:
    """Contacts of each side of each socket whose edges the `rims` are; each comes with the id of its face."""
    lots: list[Contacts] = []
    flat = [face for face in faces if isinstance(face.fit, Fit) and isinstance(face.fit.shape, Plane)]
    for own in flat:
        normal = _outward(own)
        left = [rim for rim, face in rims if face == own.id]
        while left:
            turn = frame_along(normal)[:, :2]
            flush = np.array([float(rim.normal @ normal) > 0.99 for rim in left])
            points, ways = (np.array([getattr(rim, name) for rim in left]) @ turn for name in _PLACED)
            found = _mouth(points[flush], ways[flush], config)
            if found is None:
                break
            level = float(np.median(np.array([rim.point for rim in left])[flush] @ normal))
            lots += _walls(found, turn, turn @ found.center + level * normal, normal, own.id, faces, config)
            about = np.linalg.norm(points - found.center, axis=1) < 2.0 * found.inside + config.beyond
            left = [rim for rim, gone in zip(left, about, strict=True) if not gone]
    return lots


def _outward(face: Face) -> Floats:
    assert isinstance(face.fit, Fit)
    assert isinstance(face.fit.shape, Plane)
    return np.asarray(face.fit.shape.direction * (1.0 if face.fit.convex else -1.0))


_PLACED = ("point", "outward")
_QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])  # turns rows back by that


def _mouth(points: Floats, ways: Floats, config: SocketsConfig) -> _Mouth | None:
    """The socket that most of (n, 2) edges are of, with the (n, 2) ways into it; None where there is none."""
    angles, best = np.arctan2(ways[:, 1], ways[:, 0]), None
    most = 0
    for sides in config.sides:
        step = 2.0 * np.pi / sides
        for first in angles:
            side = np.round((angles - first) / step).astype(int) % sides
            turned = np.abs((angles - first + 0.5 * step) % step - 0.5 * step) < config.turned
            found = _through(points[turned], angles[turned], side[turned], first, sides, config)
            if found is None:
                continue
            mouth, members = found
            about = int(_about(points, mouth, config).sum())
            if members > most and 0 < config.share * about <= members:
                best, most = mouth, members
        if best is not None:
            return best
    return None


def _through(
    points: Floats, angles: Floats, side: Floats, first: float, sides: int, config: SocketsConfig
) -> tuple[_Mouth, int] | None:
    """The socket through edges of its sides, and how many are of it: those far off are left out, one by one."""
    step = 2.0 * np.pi / sides
    lean = float(np.median(angles - first - step * np.round((angles - first) / step)))
    turns = first + lean + step * np.arange(sides)
    ways = np.column_stack([np.cos(turns), np.sin(turns)])
    kept = np.ones(len(points), dtype=bool)
    while len(np.unique(side[kept])) >= sides - config.unseen:
        out = ways[side[kept]]
        rows, seen = np.column_stack([out, -np.ones(len(out))]), (out * points[kept]).sum(axis=1)
        (x, y, inside), _, rank, _ = np.linalg.lstsq(rows, seen, rcond=None)
        if rank < 3:
            return None
        along = np.abs(((points[kept] - [x, y]) @ _QUARTER * out).sum(axis=1))
        off = np.abs(rows @ [x, y, inside] - seen)
        beside = along > config.within * inside * np.tan(0.5 * step)
        if off.max() < config.off and not beside.any():
            low, high = config.inside
            mouth = _Mouth(np.array([x, y]), float(inside), ways)
            return (mouth, int(kept.sum())) if low < inside < high else None
        worst = [int(np.argmax(off))] if off.max() >= config.off else np.flatnonzero(beside)
        kept[np.flatnonzero(kept)[worst]] = False
    return None


def _about(points: Floats, mouth: _Mouth, config: SocketsConfig) -> Bools:
    """(n,) which of (n, 2) edges lie inside a socket, or just outside its sides."""
    past = ((mouth.center - points) @ mouth.ways.T).max(axis=1) - mouth.inside
    return np.asarray(past < config.beyond)


def _walls(
    mouth: _Mouth,
    turn: Floats,
    center: Floats,
    normal: Floats,
    own: int,
    faces: Sequence[Face],
    config: SocketsConfig,
) -> list[Contacts]:
    """Contacts of every side, down to the flat face below; `turn` (3, 2) spans the plane, `normal` leads out."""
    half = 2.0 * mouth.inside * np.tan(np.pi / len(mouth.ways))
    lots = []
    for way in mouth.ways @ turn.T:
        foot, along = center - mouth.inside * way, np.cross(normal, way)
        deep = depth_below(foot, normal, own, faces)
        points = [
            foot + u * half * along - v * deep * normal
            for u in (-config.along, 0.0, config.along)
            for v in config.rows
        ]
        normals = np.tile(way, (len(points), 1))
        lots.append(Contacts.of(np.array(points), normals, config.sigma, config.normal_sigma, touch=NOT_FELT))
    return lots
