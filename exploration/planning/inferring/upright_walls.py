"""Walls below single rims: upright on their face, as most are.

A rim of a flat face tells where a wall is and which way it looks, not how it stands nor how deep it goes.  It
stands upright on the face, runs as the object's other faces do where it nearly does, and goes down to the next
flat face that was felt beside it; not to the object's back, where that would make a gap many times as deep as it
is wide.  That is likely and not measured, so the wall is marked as inferred (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

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
    same_wall,
    width_of_gap,
)
from exploration.planning.touching.findings import SeenRim
from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face


@dataclass(frozen=True)
class UprightWallConfig:
    """When a rim makes a wall by itself, and how deep that goes."""

    parallel: float = 0.05  # most cosine between the way that a wall looks and its face's
    known: float = (
        0.998  # least cosine between the way out of a rim and the object's own, or between two faces
    )
    likely: float = 0.93  # least cosine between them of a rim that nearly runs so
    most: int = 16  # walls of one rim each
    same: float = 1.2  # [mm] between walls that are one
    opposite: float = 0.99  # least cosine between the way that a wall looks and the one back
    straight: float = 20.0  # [mm] of a rim in one look, from which it is straight, whichever way it runs,
    bends: tuple[float, float] = (0.9, 0.998)  # unless another, that far turned from it in cosines,
    bent: float = 45.0  # [mm] from it, shows that it is of a wide circle
    deep: float = 3.0  # [mm] of such a wall, where nothing tells more
    felt: float = 16.0  # [mm] from a rim, within which the face was felt that its wall leads to
    slender: float = 5.0  # times as deep as it is wide, from which a gap reaches through to no other side,
    thick: float = 45.0  # [mm] and that far away at least


def upright_walls(
    rims: Sequence[SeenRim],
    faces: Sequence[Face],
    beside: Sequence[SeenRim] = (),
    config: UprightWallConfig = UprightWallConfig(),
) -> list[Contacts]:
    """Contacts of a wall below each rim of a flat face that no other agrees with: upright on it, as most are.

    What was only seen `beside` others may be a piece of a round rim; it counts where it runs as the object does.
    So may one that was looked for: where it runs otherwise it is long, or another has to look back at it, as in a
    hexagon.
    """
    turned = _turned(faces)
    ways = directions(faces)
    long = [rim.outward for rim, face in rims if face not in turned and _straight(rim, face, rims, config)]
    ways += [own for own in long if not any(abs(float(way @ own)) > config.likely for way in ways)]
    alike = [rim for rim in beside if any(abs(float(way @ rim[0].outward)) > config.likely for way in ways)]
    found, unsure = list[Wall](), list[Wall]()
    flat_rims = [(rim, face) for rim, face in [*rims, *alike] if face not in turned]
    for rim, face in each_once(flat_rims)[: config.most]:
        normal = max(ways, key=lambda way: abs(float(way @ rim.outward)), default=rim.outward)
        normal = np.asarray(normal * np.sign(normal @ rim.outward))
        sure = float(normal @ rim.outward) > config.known
        normal = normal if float(normal @ rim.outward) > config.likely else rim.outward
        if abs(float(normal @ rim.normal)) < config.parallel:
            straight = replace(rim, tangent=np.cross(normal, rim.normal))
            gap = width_of_gap((rim, face), flat_rims, faces)
            through = max(config.slender * gap, config.thick)
            deep = depth_below(rim.point, rim.normal, face, faces, config, through)
            down = deep * (
                rim.normal - float(rim.normal @ normal) * normal
            )  # the pad leans, and the wall does not
            wall = between(along(straight), along(straight) - down), normal
            join(found if sure else unsure, wall)
    for points, normal in [wall for wall in unsure if _looked_back_at(wall, [*found, *unsure], config)]:
        if not any(same_wall(wall, (points, normal), config.same) for wall in found):
            found.append((points, normal))
    return contacts_of(found)


def _straight(rim: Sighting, face: int, rims: Sequence[SeenRim], config: UprightWallConfig) -> bool:
    """Whether a rim is too long to be of a circle, unless that is wide and others of the face show it bend."""
    low, high = config.bends
    bent = (
        low < float(other.outward @ rim.outward) < high
        and float(np.linalg.norm(other.point - rim.point)) < config.bent
        for other, own in rims
        if own == face and other.length > config.straight
    )
    return rim.length > config.straight and not any(bent)


def _looked_back_at(wall: Wall, walls: Sequence[Wall], config: UprightWallConfig) -> bool:
    return any(float(wall[1] @ normal) < -config.opposite for _, normal in walls)


def depth_below(
    point: Floats,
    normal: Floats,
    own: int,
    faces: Sequence[Face],
    config: UprightWallConfig = UprightWallConfig(),
    through: float = np.inf,
) -> float:
    """[mm] from a (3,) rim of face `own` down to the next flat face parallel to it, if one was felt beside it.

    One that looks the other way is the object's back, and counts down to `through` [mm] only.
    """
    deep = [config.deep]
    for face in faces:
        if face.id == own or not isinstance(face.fit, Fit) or face.fit.kind != "plane":
            continue
        if abs(float(face.fit.shape.direction @ normal)) > config.known:
            away = point - face.contacts.points
            down = np.median(away @ normal)
            aside = np.linalg.norm(away - np.outer(away @ normal, normal), axis=1)
            most = through if float(face.contacts.normals.mean(axis=0) @ normal) < 0.0 else np.inf
            deep += [float(down)] if 0.0 < down < most and aside.min() < config.felt else []
    return min(deep[1:], default=config.deep)


def _turned(faces: Sequence[Face]) -> set[int]:
    return {f.id for f in faces if isinstance(f.fit, Fit) and f.fit.kind != "plane"}
