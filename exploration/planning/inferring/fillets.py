"""Fillets where a wall stands on a face, as pictures of the face show them rise before it (`edge_profiles`)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np

from exploration.planning.known.mosaic import Mosaic
from exploration.sensing.lines.edge_profiles import Taxels, size_of_fillet
from primitives.arrays import Bools, Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.flat_edges import Flat, Stretch, flats, from_wall
from primitives.patch_graph import Face
from primitives.shapes import Cylinder

FILLET = "a fillet is inferred from how the face rises before a wall"


@dataclass(frozen=True)
class FilletsConfig:
    """Where fillets are looked for."""

    square: float = 0.1  # most cosine between the normals of a face and a wall on it
    upright: float = 0.999  # least cosine between the face's and the axis of a round wall
    low: float = 25.0  # [mm] over the face, that a wall is known at most
    above: float = 0.8  # share of a wall's contacts that are so, at least, by
    over: float = 1.0  # [mm]
    near: float = 16.0  # [mm] from a wall, that its face was felt
    ends: float = 2.0  # [mm] left out at either end of a straight one
    long: float = 8.0  # [mm] of it, at least
    tells: tuple[float, float] = (0.5, 9.0)  # [mm] from a wall, where taxels tell of a fillet,
    own: tuple[float, float] = (9.0, 18.0)  # [mm] and where of how deep the pad lies
    few: int = 3  # of them, at least
    missing: float = (
        0.15  # [mm] that a taxel is pressed in less than the face stands before it, where that is not
    )
    images: int = 40  # at most
    rows: int = 12  # of contacts along a straight one,
    round: int = 24  # round a round one,
    across: tuple[float, ...] = (0.06, 0.28, 0.5, 0.72, 0.94)  # and of its turn
    sigma: float = 0.15  # [mm]
    normal_sigma: float = 0.05  # [rad]


def fillets(
    faces: Sequence[Face], mosaic: Mosaic, config: FilletsConfig = FilletsConfig()
) -> list[tuple[Contacts, str]]:
    """Contacts of each, and the kind of face that they are of."""
    known = list(flats(faces))
    found = [lot for one, other in permutations(known, 2) if (lot := _straight(one, other, mosaic, config))]
    for floor in known:
        for fit, places in _standing(floor, faces, config):
            if (lot := _round(floor, fit, places, mosaic, config)) is not None:
                found.append(lot)
    return found


def _standing(floor: Flat, faces: Sequence[Face], config: FilletsConfig) -> Iterator[tuple[Fit, Floats]]:
    """Round walls upright on a flat face that were felt, and (n, 3) places of each."""
    for face in faces:
        fit, felt = face.fit, (face.contacts.touch != NOT_FELT).any()
        if not felt or not isinstance(fit, Fit) or not isinstance(fit.shape, Cylinder):
            continue
        if abs(float(fit.shape.direction @ floor.normal)) > config.upright:
            yield fit, face.contacts.points


def _stands(up: Floats, config: FilletsConfig) -> bool:
    """Whether a wall that was felt so high [mm] over a face stands on it."""
    return float(np.mean(up > config.over)) > config.above and float(up.min()) < config.low


def _round(
    floor: Flat, fit: Fit, places: Floats, mosaic: Mosaic, config: FilletsConfig
) -> tuple[Contacts, str] | None:
    """The fillet round a boss, or round the floor of a pocket."""
    shape, side = fit.shape, 1.0 if fit.convex else -1.0
    assert isinstance(shape, Cylinder)
    inside = from_wall(fit)

    def away(points: Floats) -> Floats:
        return -inside(points)

    before = away(floor.felt)
    if not _stands(places @ floor.normal - floor.offset, config) or np.mean(before < -config.over) > 0.1:
        return None
    if not (before < config.near).any():
        return None
    radius = size_of_fillet([_taxels(mosaic, floor, away, lambda p: np.ones(len(p), dtype=bool), config)])
    if radius is None or (not fit.convex and radius > 0.8 * shape.radius):
        return None
    turns = 2.0 * np.pi * np.arange(config.round) / config.round
    radial = np.column_stack([np.cos(turns), np.sin(turns)]) @ shape.frame[:, :2].T
    foot = shape.anchor + float(floor.offset - shape.anchor @ floor.normal) * floor.normal
    points, normals = [], []
    for way in radial:
        ways = _ways(floor.normal, side * way, config)
        center = foot + (shape.radius + side * radius) * way + radius * floor.normal
        points.append(center - radius * ways)
        normals.append(ways)
    lot = Contacts.of(
        np.concatenate(points), np.concatenate(normals), config.sigma, config.normal_sigma, touch=NOT_FELT
    )
    return lot, "torus"


def _straight(floor: Flat, wall: Flat, mosaic: Mosaic, config: FilletsConfig) -> tuple[Contacts, str] | None:
    """The fillet between a flat face and a flat wall that stands on it; of the two the face is the larger."""
    if abs(float(floor.normal @ wall.normal)) > config.square or len(floor.felt) < len(wall.felt):
        return None
    near, sides = [], ((floor, wall), (wall, floor))
    for own, other in sides:
        away = _over(other)(own.felt)
        if np.mean(away < -config.over) > 0.1 or not _stands(_over(own)(other.felt), config):
            return None
        near.append(own.felt[away < config.near])
    edge = Stretch.of(floor, wall, near, config.ends)
    if edge is None or edge.length < config.long:
        return None
    lots = [_taxels(mosaic, own, _over(other), edge.beside, config) for own, other in sides]
    radius = size_of_fillet([lot for lot in lots if lot])
    if radius is None:
        return None
    center = edge.corner + radius * (floor.normal + wall.normal)
    rows = edge.rows(config.rows)
    ways = _ways(floor.normal, wall.normal, config)
    points = ((center + rows)[:, None] - radius * ways).reshape(-1, 3)
    lot = Contacts.of(
        points, np.tile(ways, (len(rows), 1)), config.sigma, config.normal_sigma, touch=NOT_FELT
    )
    return lot, "cylinder"


def _over(wall: Flat) -> Callable[[Floats], Floats]:
    """[mm] before a flat wall, of (n, 3) places."""
    return lambda places: np.asarray(places @ wall.normal - wall.offset)


def _ways(one: Floats, other: Floats, config: FilletsConfig) -> Floats:
    """(k, 3) normals across a fillet, from that of the face to that of the wall."""
    turn = 0.5 * np.pi * np.array(config.across)[:, None]
    return np.asarray(np.cos(turn) * one + np.sin(turn) * other)


def _taxels(
    mosaic: Mosaic,
    own: Flat,
    away: Callable[[Floats], Floats],
    beside: Callable[[Floats], Bools],
    config: FilletsConfig,
) -> list[Taxels]:
    """Those of every pad that lay on a face and up to a wall."""
    found = []
    for image in mosaic.flush(own.normal * own.offset, own.normal):
        x, on = away(image.places), beside(image.places)
        settled = on & (x > config.own[0]) & (x < config.own[1]) & (image.depth > 0.5 * image.before)
        near = on & (x > config.tells[0]) & (x < config.tells[1])
        if settled.sum() < config.few or not near.any():
            continue
        lift = float(np.median(image.depth[settled] - image.before[settled]))
        before = image.before + lift
        near &= image.depth > before - config.missing  # a hole in the face is no fillet
        if near.any():
            found.append(Taxels(x[near], before[near], image.depth[near], image.sigma[near], image.spread))
    return found[:: max(1, len(found) // config.images)]
