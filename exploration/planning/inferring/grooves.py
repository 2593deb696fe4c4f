"""Grooves round cylinders, in which no array has room.

A pad that lies along a cylinder shows where its wall is and where it is not (`Mosaic.band`).  Where the wall is
missing between two heights, and that in every direction from which it was seen, a groove runs round it.  How deep
that is nobody felt.  It is taken for round, half as deep as wide, which is what a groove of a rope is; one of an
O-ring is somewhat deeper (ISO 3601-2), one of a retaining ring somewhat shallower (DIN 471).  So its face is
marked as inferred (our derivation).

A pad that lay on the narrow walls beside a groove, and sagged into that, may have read a ring that leans from the
cylinder.  The groove stands in for such a face.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from exploration.planning.known.mosaic import Band, Mosaic
from exploration.planning.open.known_face import KnownFace
from exploration.planning.open.round_rims import around
from primitives.arrays import Bools, Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.shapes import Cylinder


@dataclass(frozen=True)
class GroovesConfig:
    """What is a groove, and where its contacts are."""

    level: float = 0.5  # of the wall's own share, below which it is not there
    wall: float = 0.9  # quantile of all that is known, which is the wall's own share
    least: float = 0.4  # that this is at least, of a wall that was pressed at all,
    full: float = 0.85  # and what it would be, were the wall not so narrow that the skin blurs all of it
    wide: tuple[float, float] = (2.5, 1.2)  # [mm] at least, and of the cylinder's radius at most
    sectors: int = 4  # in which the gap was looked at, at least
    around: float = 4.2  # [rad] round the axis, that these lie over
    whole: float = 0.5  # of the gap, in which it was looked at so and none of them shows the wall
    deep: float = 0.4  # [mm] under the wall, from which what was felt in the gap tells of its face,
    out: float = 0.3  # with at least this cosine between its normal and the way out: no bore's inside,
    few: int = 3  # such contacts
    near: float = 1.0  # [mm] of the wall, and
    beside: float = 6.0  # [mm] of the gap, on whose walls a pad may lie that sags into it
    leans: tuple[float, float] = (
        0.03,
        0.3,
    )  # [rad] from the cylinder's axis: a ring that was read there is none
    ring: int = 16  # places round it
    tube: tuple[float, ...] = (-1.0, -0.5, 0.0, 0.5, 1.0)  # [rad] from its bottom, where they are
    sigma: float = 0.5  # [mm]
    normal_sigma: float = 0.05  # [rad]


@dataclass(frozen=True)
class Groove:
    """A ring that stands for a groove round a convex cylinder."""

    contacts: Contacts
    instead: frozenset[int]  # ids of faces that it stands in for


def grooves(
    known: Sequence[KnownFace],
    faces: Sequence[Face],
    mosaic: Mosaic,
    config: GroovesConfig = GroovesConfig(),
) -> list[Groove]:
    """Those of all known cylinders, but where something was felt that is a face of its own."""
    found = []
    for own in known:
        shape = own.fit.shape
        if not isinstance(shape, Cylinder) or own.side < 0.0 or not len(own.cells):
            continue
        up = (own.cells - shape.anchor) @ shape.direction
        seen = mosaic.band(shape, float(up.min()) - config.wide[0], float(up.max()) + config.wide[0])
        for low, high in _gaps(seen, config):
            instead = {face.id for face in faces if _misread(face, shape, low, high, config)}
            felt = any(_felt(face, shape, low, high, config) for face in faces if face.id not in instead)
            if config.wide[0] < high - low < config.wide[1] * shape.radius and not felt:
                found.append(Groove(_ring(shape, low, high, config), frozenset(instead)))
    return found


def _gaps(seen: Band, config: GroovesConfig) -> Iterator[tuple[float, float]]:
    """Heights [mm] between which the wall is nowhere, and is on both sides."""
    if not seen.known.any():
        return
    own = float(np.quantile(seen.share[seen.known], config.wall))
    if own < config.least:
        return
    level = config.level * max(own, config.full)
    looked = np.array([_all_round(column, config) for column in seen.known.T])
    mean = np.where(seen.known, seen.share, 0.0).sum(axis=0) / np.maximum(seen.known.sum(axis=0), 1)
    gone = looked & ~(seen.known & (seen.share > level)).any(axis=0)
    walls = np.flatnonzero(looked & (mean > level))
    for below, above in (pair for pair in pairwise(walls.tolist()) if pair[1] - pair[0] > 1):
        between = slice(below + 1, above)
        ends = ([below, below + 1], [above, above - 1])
        if looked[[below + 1, above - 1]].all() and float(gone[between].mean()) > config.whole:
            low, high = (float(np.interp(-level, -mean[end], seen.heights[end])) for end in ends)
            yield low, high


def _all_round(known: Bools, config: GroovesConfig) -> bool:
    """Whether so many sectors are known that a gap in all of them runs round."""
    turns = 2.0 * np.pi * np.flatnonzero(known) / len(known)
    return len(turns) >= config.sectors and around(turns) > config.around


def _felt(face: Face, shape: Cylinder, low: float, high: float, config: GroovesConfig) -> bool:
    """Whether a face was felt in a gap, under the cylinder and looking out as that does."""
    felt = face.contacts.select(face.contacts.touch != NOT_FELT)
    up, deep = _beside(felt, shape)
    facing = (felt.normals * shape.normals(felt.points)).sum(axis=1)
    inside = (up > low) & (up < high) & (deep > config.deep) & (facing > config.out)
    return int(inside.sum()) >= config.few


def _misread(face: Face, shape: Cylinder, low: float, high: float, config: GroovesConfig) -> bool:
    """Whether a face is a ring that leans from a cylinder's axis, read where a pad lay over a gap in that."""
    if not isinstance(face.fit, Fit) or face.fit.kind != "torus":
        return False
    felt = face.contacts.select(face.contacts.touch != NOT_FELT)
    up, deep = _beside(felt, shape)
    over = (up > low - config.beside) & (up < high + config.beside) & (np.abs(deep) < config.near)
    lean = float(np.linalg.norm(np.cross(face.fit.shape.direction, shape.direction)))
    return len(felt) > 0 and bool(over.all()) and config.leans[0] < lean < config.leans[1]


def _beside(felt: Contacts, shape: Cylinder) -> tuple[Floats, Floats]:
    """(n,) heights along a cylinder, and (n,) depths under it [mm], of contacts."""
    return (felt.points - shape.anchor) @ shape.direction, -shape.signed_distance(felt.points)


def _ring(shape: Cylinder, low: float, high: float, config: GroovesConfig) -> Contacts:
    """Of a ring whose tube's middle runs on the cylinder."""
    turn = 2.0 * np.pi * np.arange(config.ring) / config.ring
    out: Floats = np.column_stack([np.cos(turn), np.sin(turn)]) @ shape.frame[:, :2].T
    middle = shape.anchor + 0.5 * (low + high) * shape.direction + shape.radius * out
    inward = [np.sin(lean) * shape.direction - np.cos(lean) * out for lean in config.tube]
    points = np.concatenate([middle + 0.5 * (high - low) * way for way in inward])
    return Contacts.of(
        points,
        -np.concatenate(inward),
        sigma=config.sigma,
        normal_sigma=config.normal_sigma,
        touch=NOT_FELT,
    )
