"""Walls between the two sides of a plate, from the outline at which both were seen to end; of a step, the upper.

Straight pieces of it are flat walls and round ones cylinders, upright between the sides, where no face is known
there.  An outline that such walls leave unexplained for the most part, as of a gear, is made by none of them (our
derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from primitives.arcs import arcs, evenly
from primitives.arrays import Bools, Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.outlines import depth_inside
from primitives.patch_graph import Face
from primitives.plate import Plate
from primitives.pose import inverse, transform_points


@dataclass(frozen=True)
class PlateWallsConfig:
    """When a piece of an outline is a wall, and when a wall is a piece of it."""

    off: float = 1.2  # [mm] from an outline, from which a place is on none
    denied: float = 0.3  # share of a wall's places, from which it is no part of an outline
    borders: float = 0.8  # [mm] between an outline and what neither side has, that it was seen as
    across: float = 0.1  # most cosine between the way of a wall and the plate's
    beside: float = 8.0  # [mm] more than the plate is thick, from a place of the outline to one of its wall
    freeform: float = 0.4  # share of an outline that walls leave, from which it is made by none
    step: float = 0.5  # [mm] between the places of an outline
    longer: float = 8.0  # [mm] of a straight piece, without
    many: int = 12  # such pieces of one outline, that are teeth and no walls
    most: int = 6  # of a pocket's, that are walls of the whole body: of a letter they are its outline's alone
    trim: float = 1.5  # [mm] of its ends, which the rubber rounds
    bends: float = 0.15  # [mm] of its sagitta at most
    told: float = 0.5  # share of a piece that known walls make, from which it is theirs
    near: float = 0.5  # [mm] of an arc's places from its circle
    deep: float = 1.0  # [mm] between the two sides, or a third of the thickness, of what is felt on neither,
    past: float = 0.8  # [mm] past where both end,
    further: float = 6.0  # [mm] from a place of the outline, which is no wall then
    rows: tuple[float, ...] = (-0.3, 0.0, 0.3)  # of the thickness, where contacts of a wall are,
    below: tuple[float, ...] = (0.5, 1.2, 2.5)  # and [mm] below the upper side, where nobody saw the lower
    apart: int = 4  # places from one of them to the next
    sigma: float = 0.2  # [mm]
    normal_sigma: float = 0.03  # [rad]


def plate_walls(
    plate: Plate, faces: Sequence[Face], config: PlateWallsConfig = PlateWallsConfig()
) -> list[tuple[Contacts, str]]:
    """Contacts of each wall of a plate that none of its `faces` is, which nobody felt, and its kind."""
    found: list[tuple[Contacts, str]] = []
    for rim in plate.there:
        flat: list[tuple[Contacts, str]] = []
        places = evenly(rim, config.step)
        left = np.abs(depth_inside(plate.missing, places)) < config.borders
        left &= ~_told(plate, places, faces, config)
        for arc in arcs(rim):
            away = places - arc.center
            far = np.linalg.norm(away, axis=1)
            on = np.abs(far - arc.radius) < config.near
            if on.any() and float(left[on].mean()) > 1.0 - config.told:
                found.append((_wall(plate, places[on], away[on] / far[on, None], config), "cylinder"))
            left &= ~on
        for corner, after in zip(rim, np.roll(rim, -1, axis=0), strict=True):
            piece = _straight(places, left, corner, after, config)
            if piece is not None:
                flat.append((_wall(plate, *piece, config), "plane"))
        found += flat if len(flat) <= (config.most if plate.step else config.many) else []
    return found


def _straight(
    places: Floats, left: Bools, corner: Floats, after: Floats, config: PlateWallsConfig
) -> tuple[Floats, Floats] | None:
    """(k, 2) places on the line of a straight piece between two corners, and (k, 2) ways across it."""
    length = float(np.linalg.norm(after - corner))
    if length < config.longer:
        return None
    along = (after - corner) / length
    t, off = (places - corner) @ along, np.abs((places - corner) @ [along[1], -along[0]])
    on = (t > config.trim) & (t < length - config.trim) & (off < config.near)
    if on.sum() < 2 * config.apart or float(left[on].mean()) <= 1.0 - config.told:
        return None
    middle = places[on].mean(axis=0)
    across = np.linalg.svd(places[on] - middle)[2][1]
    t, off = (places[on] - middle) @ [across[1], -across[0]], (places[on] - middle) @ across
    if abs(float(np.polyfit(t, off, 2)[0])) * (0.5 * float(np.ptp(t))) ** 2 > config.bends:
        return None
    return places[on] - np.outer(off, across), np.tile(across, (int(on.sum()), 1))


def _wall(plate: Plate, flat: Floats, ways: Floats, config: PlateWallsConfig) -> Contacts:
    """Contacts of a wall at (k, 2) places, turned to the side on which the plate is missing."""
    flat, ways = flat[:: config.apart], ways[:: config.apart]
    inside = depth_inside(plate.there, flat + ways) > depth_inside(plate.there, flat - ways)
    ways = -ways if inside.mean() > 0.5 else ways
    half = 0.5 * plate.thick
    under = [max(half - deep, -half) for deep in config.below]
    levels = under if plate.lies else [row * plate.thick for row in config.rows]
    rows = [np.column_stack([flat, np.full(len(flat), level)]) for level in levels]
    points = transform_points(plate.pose, np.concatenate(rows))
    normals = np.tile(ways @ plate.pose[:3, :2].T, (len(rows), 1))
    return Contacts.of(points, normals, config.sigma, config.normal_sigma, touch=NOT_FELT)


def denies(plate: Plate, places: Floats, config: PlateWallsConfig = PlateWallsConfig()) -> bool:
    """Whether (n, 3) places of a wall between the sides of a plate lie where it goes on, or is not at all.

    A step denies none: what is under its upper face was not seen.
    """
    if plate.step:
        return False
    own = _between(plate, places)
    off = np.maximum(depth_inside(plate.there, own), depth_inside(plate.missing, own)) > config.off
    return len(own) > 0 and float(off.mean()) > config.denied


def along_it(plate: Plate, places: Floats, config: PlateWallsConfig = PlateWallsConfig()) -> bool:
    """Whether (n, 3) places of a wall lie between the sides of a plate and along it."""
    return bool((depth_inside(plate.there, _between(plate, places)) > -config.beside).any())


def freeform(plate: Plate, faces: Sequence[Face], config: PlateWallsConfig = PlateWallsConfig()) -> bool:
    """Whether walls between its two sides make little of the outline of a plate, where that was seen.

    It was seen where what both sides have borders on what neither has.
    """
    flat = np.concatenate([np.empty((0, 2)), *(evenly(rim, config.step) for rim in plate.there)])
    flat = flat[np.abs(depth_inside(plate.missing, flat)) < config.borders]
    return len(flat) > 0 and float(_told(plate, flat, faces, config).mean()) < 1.0 - config.freeform


def _told(plate: Plate, flat: Floats, faces: Sequence[Face], config: PlateWallsConfig) -> Bools:
    """(n,) which of (n, 2) places of an outline a known wall makes."""
    places = transform_points(plate.pose, np.column_stack([flat, np.zeros(len(flat))]))
    told = np.zeros(len(places), dtype=bool)
    for face in faces:
        if isinstance(face.fit, Fit) and _stands(face.fit, plate.pose[:3, 2], config):
            near = np.abs(face.fit.shape.signed_distance(places)) < config.off
            rows = np.flatnonzero(near & ~told)
            beside = KDTree(face.contacts.points).query(places[rows])[0] < plate.thick + config.beside
            told[rows[beside]] = True
    further = _felt_past(plate, faces, config)
    if len(further):
        told |= KDTree(further).query(flat)[0] < config.further
    return told


def _felt_past(plate: Plate, faces: Sequence[Face], config: PlateWallsConfig) -> Floats:
    """(n, 2) where something was felt between the sides of a plate, past where both of them end.

    A side that is chamfered, rounded or bulges is there, and no wall is where its faces end.
    """
    felt = [face.contacts.points[face.contacts.touch != NOT_FELT] for face in faces]
    own = transform_points(inverse(plate.pose), np.concatenate([np.empty((0, 3)), *felt]))
    own = own[np.abs(own[:, 2]) < 0.5 * plate.thick - min(config.deep, plate.thick / 3.0), :2]
    return np.asarray(own[depth_inside(plate.missing, own) > config.past])


def _between(plate: Plate, places: Floats) -> Floats:
    """(k, 2) those of (n, 3) places that lie between the sides of a plate."""
    own = transform_points(inverse(plate.pose), places)
    return np.asarray(own[np.abs(own[:, 2]) < 0.5 * plate.thick, :2])


def _stands(wall: Fit, up: Floats, config: PlateWallsConfig) -> bool:
    """Whether a wall stands upright along a (3,) way."""
    along = abs(float(wall.shape.direction @ up))
    return along < config.across if wall.kind == "plane" else along > 1.0 - config.across
