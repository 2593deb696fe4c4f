"""Grooves round cylinders, in which no array has room.

A pad that lies along a cylinder shows where its wall is and where it is not (`Mosaic.band`).  Where the wall is
missing between two heights, and that in every direction from which it was seen, a groove runs round it.  Where a
small array felt its bottom, that tells how deep it is, and that it is round (`groove_tubes`).  Else it is taken
for round, half as deep as wide, which is what a groove of a rope is; one of an O-ring is somewhat deeper (ISO
3601-2), one of a retaining ring somewhat shallower (DIN 471).  So its face is marked as inferred (our derivation).

A pad that lay on the narrow walls beside a groove, and sagged into that, may have read a ring that leans from the
cylinder, or a plane that touches it.  The groove stands in for such a face, and one whose bottom was felt for what
was read or inferred in it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from exploration.planning.inferring.groove_tubes import Tube, half_round, tube_felt
from exploration.planning.known.mosaic import Band, Mosaic
from exploration.planning.open.known_face import KnownFace
from primitives.arcs import around
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
    air: float = 0.2  # or under where skin felt nothing, less this,
    out: float = 0.3  # with at least this cosine between its normal and the way out: no bore's inside,
    few: int = 3  # such contacts of a face
    near: float = 1.0  # [mm] of the wall, and
    beside: float = 6.0  # [mm] of the gap, on whose walls a pad may lie that sags into it
    leans: tuple[float, float] = (
        0.03,
        0.3,
    )  # [rad] from the cylinder's axis: a ring that was read there is none
    around_it: float = 0.5  # [mm] beyond the groove, that what it stands in for may lie
    ring: int = 16  # places round it
    # shares of the way from its bottom out, where they are
    tube: tuple[float, ...] = (-0.64, -0.32, 0.0, 0.32, 0.64)
    sigma: float = 0.5  # [mm]
    normal_sigma: float = 0.05  # [rad]


@dataclass(frozen=True)
class Groove:
    """A ring that stands for a groove round a convex cylinder."""

    contacts: Contacts
    instead: frozenset[int]  # ids of faces that it stands in for
    felt: bool  # whether its bottom was
    wall: Cylinder
    low: float  # [mm] heights along it, between which it is not
    high: float
    depth: float  # [mm]
    bare: float  # [mm] under the wall, down to which skin felt nothing

    def holds(self, place: Floats, on: float = 2.0) -> bool:
        """Whether a (3,) place on the wall, to within so many mm, is where the groove runs."""
        up = float((place - self.wall.anchor) @ self.wall.direction)
        return self.low < up < self.high and abs(float(self.wall.signed_distance(place[None])[0])) < on

    def stands_beside(self, faces: Sequence[Face], on: float = 0.2) -> tuple[Face, ...]:
        """Faces without those that it stands in for, and without contacts that are its own or in the air.

        A pad that lay on the wall on both sides has its contact between them, `on` mm from where that would be.
        """
        left = ((face, ~self._in_it(face, on)) for face in faces if face.id not in self.instead)
        return tuple(face.only(kept) for face, kept in left if kept.any())

    def _in_it(self, face: Face, on: float) -> Bools:
        up, deep = _beside(face.contacts, self.wall)
        deepest = self.depth + on if self.felt else max(on, self.bare)
        between = (up > self.low) & (up < self.high) & (deep > -on) & (deep < deepest)
        return np.asarray(between & (face.contacts.touch != NOT_FELT))


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
            if config.wide[0] < high - low < config.wide[1] * shape.radius:
                found += _of(faces, shape, low, high, _bare(shape, low, high, mosaic), config)
    return found


def _of(
    faces: Sequence[Face], shape: Cylinder, low: float, high: float, bare: float, config: GroovesConfig
) -> list[Groove]:
    """The groove between two heights, if it is one; skin that came `bare` mm under the wall felt nothing."""
    instead = {face.id for face in faces if _misread(face, shape, low, high, config)}
    deep = max(config.deep, bare - config.air)
    lots = [_bottom(face, shape, low, high, deep, config) for face in faces if face.id not in instead]
    felt = [lot for lot in lots if len(lot) >= config.few]
    bottom = Contacts.concatenate(felt or lots)
    tube = tube_felt(*_beside(bottom, shape), bottom.normals @ shape.direction, low, high)
    if tube is not None:
        instead |= {face.id for face in faces if _within(face, shape, low, high, tube.depth, config)}
        ring = Contacts.concatenate([bottom, _ring(shape, tube, config)])
        return [Groove(ring, frozenset(instead), True, shape, low, high, tube.depth, bare)]
    if felt:
        return []
    tube = half_round(low, high)
    return [Groove(_ring(shape, tube, config), frozenset(instead), False, shape, low, high, tube.depth, bare)]


def _bare(shape: Cylinder, low: float, high: float, mosaic: Mosaic) -> float:
    """[mm] under the wall, down to which skin felt nothing over the middle half between two heights."""
    middle, half = 0.5 * (low + high), 0.25 * (high - low)
    return mosaic.bare(
        shape, lambda places: np.abs((places - shape.anchor) @ shape.direction - middle) < half
    )


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


def _bottom(
    face: Face, shape: Cylinder, low: float, high: float, least: float, config: GroovesConfig
) -> Contacts:
    """What was felt of a face in a gap, so deep [mm] under the cylinder and looking out as that does."""
    felt = face.contacts.select(face.contacts.touch != NOT_FELT)
    up, deep = _beside(felt, shape)
    facing = (felt.normals * shape.normals(felt.points)).sum(axis=1)
    return felt.select((up > low) & (up < high) & (deep > least) & (facing > config.out))


def _within(
    face: Face, shape: Cylinder, low: float, high: float, depth: float, config: GroovesConfig
) -> bool:
    """Whether all that is known of a face lies in a groove of that depth [mm]."""
    up, deep = _beside(face.contacts, shape)
    inside = (up > low - config.around_it) & (up < high + config.around_it)
    inside &= (deep > -config.around_it) & (deep < depth + config.around_it)
    return len(inside) > 0 and bool(inside.all())


def _misread(face: Face, shape: Cylinder, low: float, high: float, config: GroovesConfig) -> bool:
    """Whether a face was read where a pad lay over a gap: a ring that leans, or a plane of a single touch."""
    if not isinstance(face.fit, Fit) or face.fit.kind not in ("torus", "plane"):
        return False
    felt = face.contacts.select(face.contacts.touch != NOT_FELT)
    up, deep = _beside(felt, shape)
    over = (up > low - config.beside) & (up < high + config.beside) & (np.abs(deep) < config.near)
    if not len(felt) or not over.all():
        return False
    if face.fit.kind == "plane":
        return len(np.unique(felt.touch)) == 1 and bool((up < low).any() and (up > high).any())
    lean = float(np.linalg.norm(np.cross(face.fit.shape.direction, shape.direction)))
    return config.leans[0] < lean < config.leans[1]


def _beside(felt: Contacts, shape: Cylinder) -> tuple[Floats, Floats]:
    """(n,) heights along a cylinder, and (n,) depths under it [mm], of contacts."""
    return (felt.points - shape.anchor) @ shape.direction, -shape.signed_distance(felt.points)


def _ring(shape: Cylinder, tube: Tube, config: GroovesConfig) -> Contacts:
    """Places of a ring whose tube that is."""
    turn = 2.0 * np.pi * np.arange(config.ring) / config.ring
    out: Floats = np.column_stack([np.cos(turn), np.sin(turn)]) @ shape.frame[:, :2].T
    outward = shape.radius - tube.depth + tube.radius
    middle = shape.anchor + tube.height * shape.direction + outward * out
    leans = tube.opening * np.array(config.tube)
    inward = [np.sin(lean) * shape.direction - np.cos(lean) * out for lean in leans]
    points = np.concatenate([middle + tube.radius * way for way in inward])
    return Contacts.of(
        points,
        -np.concatenate(inward),
        sigma=config.sigma,
        normal_sigma=config.normal_sigma,
        touch=NOT_FELT,
    )
