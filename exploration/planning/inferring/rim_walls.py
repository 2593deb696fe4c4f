"""Walls that no array has room to face, inferred from their rims on two faces.

A wall ends at a rim on each face that it meets, and lies in the plane of both: across t1 x t2 where the rims are
not parallel, else across t x (p2 - p1).  Two rims are of one wall where that plane holds both, runs as the
object's other faces do or stands upright on two that are parallel, and both faces are open to the same side of
it.  An upright one runs as those faces do where its rims are too short to tell that it does not.  Rims on opposite
faces that would make a gap many times as deep as it is wide are those of two shallow ones, as of letters engraved
on both.  That is likely and not measured, so the wall is marked as inferred (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exploration.control.sighting import Sighting
from exploration.planning.inferring.rimmed_wall import (
    Wall,
    along,
    between,
    contacts_of,
    directions,
    each_once,
    join,
    width_of_gap,
)
from exploration.planning.touching.findings import SeenRim
from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.patch_graph import Face

_SLOPE = float(np.sqrt(12.0))  # a line's direction errs by this times its offset's error, over its length


@dataclass(frozen=True)
class RimWallsConfig:
    """When two rims are of one wall."""

    parallel: float = 0.05  # sine of the angle from which two rims are not parallel
    coplanar: float = 0.4  # [mm] of one rim from the other's wall
    known: float = 0.998  # least cosine between a wall's direction and one that the object has
    faces: float = 0.9  # most cosine between the faces of the two rims
    turn: float = 0.03  # [rad] error of a rim's direction that its own sigma does not tell
    sigmas: float = 3.0  # standard deviations of it, within which a wall runs as the object's faces do
    slender: float = 5.0  # times as deep as it is wide, from which a gap is none that reaches through


def rim_walls(
    rims: Sequence[SeenRim], faces: Sequence[Face], config: RimWallsConfig = RimWallsConfig()
) -> list[Contacts]:
    """Contacts of each wall that two rims agree on."""
    ways, rims = directions(faces), each_once(rims)
    found: list[Wall] = []
    for k, (a, face) in enumerate(rims):
        for b, other in rims[k + 1 :]:
            normal = None if face == other else _across(a, b, ways, config)
            if normal is not None and not _too_slender((a, face), (b, other), rims, faces, config):
                join(found, (between(along(a), along(b)), normal))
    sides: list[Wall] = []
    for floor in found:
        for side in _sides(rims, floor, ways, config):
            join(sides, side)
    return contacts_of([*found, *sides])


def _too_slender(
    a: SeenRim, b: SeenRim, rims: Sequence[SeenRim], faces: Sequence[Face], config: RimWallsConfig
) -> bool:
    """Whether a gap that reaches from a rim to one on an opposite face would be far deeper than it is wide."""
    if float(a[0].normal @ b[0].normal) > -config.known:
        return False
    deep = abs(float((b[0].point - a[0].point) @ a[0].normal))
    return deep > config.slender * max(width_of_gap(rim, rims, faces) for rim in (a, b))


def _sides(
    rims: Sequence[SeenRim],
    floor: Wall,
    ways: Sequence[Floats],
    config: RimWallsConfig,
) -> list[Wall]:
    """Upright walls from a floor to two rims of one face that look to each other across it."""
    places, up = floor
    out: list[Wall] = []
    for k, (a, face) in enumerate(rims):
        for b, other in rims[k + 1 :]:
            if face != other or a.normal @ up < config.known or a.outward @ b.outward > -config.known:
                continue
            deep = float((a.point - places.mean(axis=0)) @ up)
            across = sorted(float((rim.point - places.mean(axis=0)) @ a.outward) for rim in (a, b))
            if deep > 0.0 and across[0] < 0.0 < across[1] and (b.point - a.point) @ a.outward > 0.0:
                for rim in (a, b):
                    way = max(ways, key=lambda w: abs(float(w @ rim.outward)))
                    if abs(float(way @ rim.outward)) > config.known:
                        normal = np.asarray(way * np.sign(way @ rim.outward))
                        out.append((between(along(rim), along(rim) - deep * up), normal))
    return out


def _across(a: Sighting, b: Sighting, ways: Sequence[Floats], config: RimWallsConfig) -> Floats | None:
    """(3,) the way that a wall looks which ends at both rims; None where there is none."""
    if float(a.normal @ b.normal) > config.faces:
        return None
    apart = b.point - a.point
    normal = np.cross(a.tangent, b.tangent)
    if float(np.linalg.norm(normal)) < config.parallel:
        normal = np.cross(a.tangent, apart)
    length = float(np.linalg.norm(normal))
    if length < 1e-6:
        return None
    normal = normal / length * np.sign(normal @ a.outward)
    if normal @ b.outward < 0.5 or normal @ a.outward < 0.5:
        return None
    turned = _known(normal, ways, config.known)
    if turned is None:
        turned = _upright(a, b, normal, ways, config)
    if turned is None or abs(float(apart @ turned)) > config.coplanar:
        return None
    return np.asarray(turned * np.sign(turned @ normal))


def _upright(
    a: Sighting, b: Sighting, normal: Floats, ways: Sequence[Floats], config: RimWallsConfig
) -> Floats | None:
    """(3,) of a wall straight down from one rim to another that looks the same way; None where it leans.

    Where the rims are too short to tell it from a way that the object has, it is that.
    """
    alike = float(a.outward @ b.outward) > config.known and float(a.normal @ b.normal) < -config.known
    if not alike or abs(float(normal @ a.normal)) > config.parallel:
        return None
    turn, other = (np.hypot(_SLOPE * rim.sigma / rim.length, config.turn) for rim in (a, b))
    upright = a.outward / turn**2 + b.outward / other**2
    upright = upright - float(upright @ a.normal) * a.normal
    upright = upright / float(np.linalg.norm(upright))
    unsure = float(turn * other / np.hypot(turn, other))
    known = _known(upright, ways, float(np.cos(config.sigmas * unsure)))
    return np.asarray(upright if known is None else known * np.sign(known @ upright))


def _known(normal: Floats, ways: Sequence[Floats], alike: float) -> Floats | None:
    """(3,) of the object's ways the one nearest to a normal, or to its reverse; None of cosines under `alike`."""
    nearest = max(ways, key=lambda way: abs(float(way @ normal)), default=None)
    return nearest if nearest is not None and abs(float(nearest @ normal)) > alike else None
