"""Rounded corners of a plate that no array could make out, inferred from where both its sides end.

A corner of a plate is a strip a few taxels long, and the skin often takes its ends for the sides of a corner of
its own.  Where two walls of a plate would meet, and both sides of the plate end before that, along one circle that
both walls are tangents of, the corner is rounded.  That circle has one unknown, its radius.  The outermost places
that were felt of each side tell it, way by way; how far such places stay behind an edge, the walls themselves tell
(our derivation).  The few contacts that were felt of a corner may have passed for a flat face of their own.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numba
import numpy as np

from exploration.planning.open.known_face import KnownFace
from primitives.arrays import Floats, Ints
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.pose import frame_along
from primitives.shapes import Cylinder


@dataclass(frozen=True)
class RoundedCornersConfig:
    """What is a plate, and a rounded corner of it."""

    opposed: float = 0.998  # least cosine between a side's normal and the reverse of the other's
    thick: tuple[float, float] = (0.3, 25.0)  # [mm]
    upright: float = 0.02  # most cosine between a wall's normal and a side's
    turns: tuple[float, float] = (0.35, 2.6)  # [rad] from one wall's normal to the other's
    radii: tuple[float, float] = (4.0, 40.0)  # [mm]
    step: float = 0.1  # [mm] between radii that are tried
    bin: float = 3.0  # [mm] along a wall or an arc, of which one outermost place is taken
    least: int = 4  # of an arc, of either side
    off: float = 0.6  # [mm] of their distances from the arc, in the median
    stray: float = 2.0  # [mm] that a single one counts at most
    sharper: float = 2.0  # times as far off they are from the sharp corner
    reach: float = 12.0  # [mm] past the arc's end, within which each wall was found
    known: float = 2.5  # [mm] from a round face, that is this corner
    few: int = 12  # contacts of a flat face that may be of a corner
    arc: float = 0.4  # of the turn to either side of the middle, where contacts are laid
    rows: tuple[float, ...] = (0.2, 0.5, 0.8)  # of the plate's thickness, likewise
    count: int = 7  # contacts of a row
    sigma: float = 0.3  # [mm]
    normal_sigma: float = 0.03  # [rad]


@dataclass(frozen=True)
class _Plate:
    """Two sides of a plate, seen along its normal."""

    turn: Floats  # (3, 3), its third column along the normal
    levels: tuple[float, float]  # [mm] of the two sides along that
    sides: tuple[Floats, Floats]  # (n, 2) [mm] where each was felt


@dataclass(frozen=True)
class _Edge:
    """A wall of a plate along n . x = d, out of it."""

    face: int
    normal: Floats  # (2,)
    offset: float  # [mm]
    points: Floats  # (n, 2) [mm] where it was found


def rounded_corners(
    known: Sequence[KnownFace], faces: Sequence[Face], config: RoundedCornersConfig = RoundedCornersConfig()
) -> list[tuple[Contacts, list[int]]]:
    """Contacts of each rounded corner between two walls of a plate, and the flat faces that are no more than it.

    `faces` are all that are known by now, inferred ones as well.
    """
    found: list[tuple[Contacts, list[int]]] = []
    for plate in _plates(known, config):
        centers: list[Floats] = []
        left = list(faces)
        for one, other in combinations(_edges(plate, faces, config), 2):
            circle = _circle(plate, one, other, config)
            if circle is None or _is_known(plate, circle, faces, config):
                continue
            if all(float(np.linalg.norm(circle.center - center)) > config.known for center in centers):
                centers.append(circle.center)
                walls = (one.face, other.face)
                own = [face for face in left if face.id not in walls and _is_of(face, plate, circle, config)]
                left = [face for face in left if face not in own]
                lots = [_contacts(plate, circle, config), *(face.contacts for face in own)]
                found.append((Contacts.concatenate(lots), [face.id for face in own]))
    return found


def _plates(known: Sequence[KnownFace], config: RoundedCornersConfig) -> Iterator[_Plate]:
    flat = [own for own in known if own.fit.kind == "plane" and len(own.cells)]
    for one, other in combinations(flat, 2):
        up = one.side * one.fit.shape.direction
        deep = float((one.fit.shape.anchor - other.fit.shape.anchor) @ up)
        against = float(other.side * other.fit.shape.direction @ up) < -config.opposed
        if against and config.thick[0] < deep < config.thick[1]:
            turn, level = frame_along(up), float(one.fit.shape.anchor @ up)
            sides = (one.cells @ turn[:, :2], other.cells @ turn[:, :2])
            yield _Plate(turn, (level - deep, level), sides)


def _edges(plate: _Plate, faces: Sequence[Face], config: RoundedCornersConfig) -> list[_Edge]:
    """The flat walls that stand on a plate's sides, between their levels."""
    found: list[_Edge] = []
    low, high = plate.levels
    for face in faces:
        if not isinstance(face.fit, Fit) or face.fit.kind != "plane" or not face.fit.convex:
            continue
        normal = face.fit.shape.direction @ plate.turn
        height = face.contacts.points @ plate.turn[:, 2]
        if abs(float(normal[2])) < config.upright and ((height > low) & (height < high)).mean() > 0.5:
            flat = normal[:2] / np.linalg.norm(normal[:2])
            points = face.contacts.points @ plate.turn[:, :2]
            found.append(_Edge(face.id, flat, float(np.median(points @ flat)), points))
    return found


@dataclass(frozen=True)
class _Circle:
    """A circle that two walls are tangents of."""

    center: Floats  # (2,) [mm]
    radius: float  # [mm]
    out: Floats  # (2,) to the middle of the corner
    turn: float  # [rad] from one wall's normal to the other's


def _circle(plate: _Plate, one: _Edge, other: _Edge, config: RoundedCornersConfig) -> _Circle | None:
    """The circle on which both sides of a plate end before two walls meet; None where they do not."""
    turn = float(np.arccos(np.clip(one.normal @ other.normal, -1.0, 1.0)))
    if not config.turns[0] < turn < config.turns[1]:
        return None
    corner: Floats = np.linalg.inv(np.stack([one.normal, other.normal])) @ [one.offset, other.offset]
    out = (one.normal + other.normal) / np.linalg.norm(one.normal + other.normal)
    behind = [_behind(side, (one, other), config) for side in plate.sides]
    nearest = max(float(np.linalg.norm(edge.points - corner, axis=1).min()) for edge in (one, other))
    radii = np.arange(*config.radii, config.step)
    radii = radii[radii * np.tan(0.5 * turn) > nearest - config.reach]
    circles = [_Circle(corner - r / np.cos(0.5 * turn) * out, r, out, turn) for r in radii.tolist()]
    found: list[tuple[float, _Circle]] = []
    sides = [_before(side, circles[-1]) for side in plate.sides] if circles else []
    for circle in circles:
        last = [_outermost(side, circle, config) for side in sides]
        if min(map(len, last)) < config.least:
            continue
        short = [
            circle.radius - np.linalg.norm(places - circle.center, axis=1) - far
            for places, far in zip(last, behind, strict=True)
        ]
        off = np.minimum(np.abs(np.concatenate(short)), config.stray)
        sharp = np.concatenate(
            [_to_wall(places, one, other) - far for places, far in zip(last, behind, strict=True)]
        )
        if np.median(off) < config.off and np.median(sharp) > config.sharper * np.median(off):
            found.append((float(off.mean()), circle))
    return min(found, key=lambda item: item[0])[1] if found else None


def _behind(side: Floats, edges: Sequence[_Edge], config: RoundedCornersConfig) -> float:
    """[mm] that the outermost places of a side stay behind a wall, by the walls of a corner."""
    short: list[Floats] = []
    for edge in edges:
        along = np.array([-edge.normal[1], edge.normal[0]])
        first, last = np.quantile(edge.points @ along, [0.1, 0.9])
        beside = side[(side @ along > first) & (side @ along < last)]
        if len(beside):
            rows = _farthest(beside @ along / config.bin, beside @ edge.normal)
            short.append(edge.offset - beside[rows] @ edge.normal)
    return float(np.median(np.concatenate(short))) if short else 0.0


def _angles(places: Floats, circle: _Circle) -> Floats:
    """(n,) [rad] from the middle of a corner, of (n, 2) places as seen from its arc's center."""
    away = places - circle.center
    return np.asarray(np.arctan2(away @ np.array([-circle.out[1], circle.out[0]]), away @ circle.out))


def _before(side: Floats, circle: _Circle) -> Floats:
    """(n, 2) of the (m, 2) places of a side those that an arc, or a smaller one of that corner, is before."""
    return side[np.abs(_angles(side, circle)) < 0.5 * circle.turn]


def _outermost(side: Floats, circle: _Circle, config: RoundedCornersConfig) -> Floats:
    """(n, 2) of the (m, 2) places of a side the farthest from an arc's center, one for each piece of the arc."""
    half, piece = 0.5 * circle.turn, config.bin / circle.radius
    return np.asarray(side[farthest_of_arc(side, circle.center, circle.out, half, piece)])


@numba.njit(cache=True, error_model="numpy")
def farthest_of_arc(side: Floats, center: Floats, out: Floats, half: float, step: float) -> Ints:
    """(n,) rows of the farthest from a center in each `step` [rad] of angles within `half` of a (2,) way out."""
    first = int(np.floor(-half / step))
    rows = np.full(int(np.floor(half / step)) - first + 1, -1)
    far = np.zeros(len(rows))
    for k in range(len(side)):
        x, y = side[k, 0] - center[0], side[k, 1] - center[1]
        angle = np.arctan2(y * out[0] - x * out[1], x * out[0] + y * out[1])
        if abs(angle) < half:
            piece = int(np.floor(angle / step)) - first
            if x * x + y * y > far[piece]:
                rows[piece], far[piece] = k, x * x + y * y
    return rows[rows >= 0]


def _farthest(bins: Floats, far: Floats) -> Ints:
    """Of every bin the row that is `far`."""
    order = np.argsort(-far, kind="stable")
    _, first = np.unique(np.floor(bins[order]), return_index=True)
    return np.asarray(order[first])


def _to_wall(places: Floats, one: _Edge, other: _Edge) -> Floats:
    """(n,) [mm] from (n, 2) places to the nearer of two walls."""
    return np.asarray(np.minimum(one.offset - places @ one.normal, other.offset - places @ other.normal))


def _is_known(plate: _Plate, circle: _Circle, faces: Sequence[Face], config: RoundedCornersConfig) -> bool:
    """Whether a round face passes through the middle of an arc."""
    flat, level = circle.center + circle.radius * circle.out, 0.5 * sum(plate.levels)
    middle = np.array([*flat, level]) @ plate.turn.T
    return any(
        isinstance(face.fit, Fit)
        and isinstance(face.fit.shape, Cylinder)
        and face.fit.convex
        and abs(float(face.fit.shape.signed_distance(middle[None])[0])) < config.known
        for face in faces
    )


def _is_of(face: Face, plate: _Plate, circle: _Circle, config: RoundedCornersConfig) -> bool:
    """Whether a flat face is a few contacts of a corner's arc."""
    if not isinstance(face.fit, Fit) or face.fit.kind != "plane" or len(face.contacts) > config.few:
        return False
    low, high = plate.levels
    places = face.contacts.points @ plate.turn
    off = np.abs(np.linalg.norm(places[:, :2] - circle.center, axis=1) - circle.radius)
    on = (off < config.known) & (np.abs(_angles(places[:, :2], circle)) < 0.5 * circle.turn)
    return bool((on & (places[:, 2] > low) & (places[:, 2] < high)).all())


def _contacts(plate: _Plate, circle: _Circle, config: RoundedCornersConfig) -> Contacts:
    """Contacts of the wall round a corner, between the two sides."""
    angles = np.linspace(-config.arc, config.arc, config.count) * circle.turn
    across = np.array([-circle.out[1], circle.out[0]])
    ways = np.outer(np.cos(angles), circle.out) + np.outer(np.sin(angles), across)
    low, high = plate.levels
    rows = [low + share * (high - low) for share in config.rows]
    flat = circle.center + circle.radius * ways
    points = np.concatenate([np.column_stack([flat, np.full(len(flat), row)]) for row in rows]) @ plate.turn.T
    normals = np.tile(ways @ plate.turn[:, :2].T, (len(rows), 1))
    return Contacts.of(points, normals, config.sigma, config.normal_sigma, touch=NOT_FELT)
