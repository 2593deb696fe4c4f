"""Walls that no array has room to face, inferred from their rims on two faces.

A wall ends at a rim on each face that it meets, and lies in the plane of both: across t1 x t2 where the rims are
not parallel, else across t x (p2 - p1).  Two rims are of one wall where that plane holds both, runs as the
object's other faces do or stands upright on two that are parallel, and both faces are open to the same side of
it.  Rims on opposite faces that would make a gap many times as deep as it is wide are those of two shallow ones,
as of letters engraved on both.  That is likely and not measured, so the wall is marked as inferred (our
derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from exploration.control.sighting import Sighting
from exploration.planning.touching.findings import SeenRim
from primitives.arrays import Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face

Wall = tuple[Floats, Floats]  # (n, 3) places [mm], and the (3,) way that it looks


@dataclass(frozen=True)
class RimWallsConfig:
    """When rims are one, and when two are of one wall."""

    beside: float = 6.0  # [mm] between places of a rim that are one
    alike: float = 0.85  # least cosine between the ways out of a rim, seen twice
    parallel: float = 0.05  # sine of the angle from which two rims are not parallel
    coplanar: float = 0.4  # [mm] of one rim from the other's wall
    known: float = 0.998  # least cosine between a wall's direction and one that the object has
    faces: float = 0.9  # most cosine between the faces of the two rims
    same: float = 0.6  # [mm] between walls that are one
    slender: float = 5.0  # times as deep as it is wide, from which a gap is none that reaches through
    aside: float = 2.5  # [mm] of the way straight across it, on which its face may be felt again,
    again: float = 2.0  # [mm] at least from the rim
    looks_back: float = 0.9  # least cosine between the ways out of its two rims on one face, reversed
    most: int = 16  # walls of one rim each
    opposite: float = 0.99  # least cosine between the way that a wall looks and the one back
    likely: float = 0.93  # least cosine between the way out of such a rim and one that the object has
    straight: float = 20.0  # [mm] of a rim in one look, from which it is straight, whichever way it runs,
    bends: tuple[float, float] = (0.9, 0.998)  # unless another, that far turned from it in cosines,
    bent: float = 45.0  # [mm] from it, shows that it is of a wide circle
    deep: float = 3.0  # [mm] of such a wall, where nothing tells more
    felt: float = 16.0  # [mm] from a rim, within which the face was felt that its wall leads to
    rows: tuple[float, ...] = (0.5, 1.2, 2.5)  # [mm] from a rim, where its wall is
    sigma: float = 0.1  # [mm]
    normal_sigma: float = 0.02  # [rad]


def rim_walls(
    rims: Sequence[SeenRim], faces: Sequence[Face], config: RimWallsConfig = RimWallsConfig()
) -> list[Contacts]:
    """Contacts of each wall that two rims agree on."""
    ways, rims = _directions(faces), _once(rims, config)
    found: list[Wall] = []
    for k, (a, face) in enumerate(rims):
        for b, other in rims[k + 1 :]:
            normal = None if face == other else _across(a, b, ways, config)
            if normal is not None and not _too_slender((a, face), (b, other), rims, faces, config):
                _join(found, (_between(_along(a), _along(b)), normal), config)
    found += [side for floor in list(found) for side in _sides(rims, floor, ways, config)]
    return _contacts(found, config)


def _too_slender(
    a: SeenRim, b: SeenRim, rims: Sequence[SeenRim], faces: Sequence[Face], config: RimWallsConfig
) -> bool:
    """Whether a gap that reaches from a rim to one on an opposite face would be far deeper than it is wide."""
    if float(a[0].normal @ b[0].normal) > -config.known:
        return False
    deep = abs(float((b[0].point - a[0].point) @ a[0].normal))
    return deep > config.slender * max(_width(rim, rims, faces, config) for rim in (a, b))


def _width(seen: SeenRim, rims: Sequence[SeenRim], faces: Sequence[Face], config: RimWallsConfig) -> float:
    """[mm] from a rim to the nearest on its face that looks back at it, or to where the face was felt again."""
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


def _once(rims: Sequence[SeenRim], config: RimWallsConfig) -> list[SeenRim]:
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


def upright_walls(
    rims: Sequence[SeenRim],
    faces: Sequence[Face],
    beside: Sequence[SeenRim] = (),
    config: RimWallsConfig = RimWallsConfig(),
) -> list[Contacts]:
    """Contacts of a wall below each rim of a flat face that no other agrees with: upright on it, as most are.

    What was only seen `beside` others may be a piece of a round rim; it counts where it runs as the object does.
    So may one that was looked for: where it runs otherwise it is long, or another has to look back at it, as in a
    hexagon.
    """
    turned = _turned(faces)
    ways = _directions(faces)
    long = [rim.outward for rim, face in rims if face not in turned and _straight(rim, face, rims, config)]
    ways += [own for own in long if not any(abs(float(way @ own)) > config.likely for way in ways)]
    alike = [rim for rim in beside if any(abs(float(way @ rim[0].outward)) > config.likely for way in ways)]
    found, unsure = list[Wall](), list[Wall]()
    flat_rims = [(rim, face) for rim, face in [*rims, *alike] if face not in turned]
    for rim, face in _once(flat_rims, config)[: config.most]:
        normal = max(ways, key=lambda way: abs(float(way @ rim.outward)), default=rim.outward)
        normal = np.asarray(normal * np.sign(normal @ rim.outward))
        sure = float(normal @ rim.outward) > config.known
        normal = normal if float(normal @ rim.outward) > config.likely else rim.outward
        if abs(float(normal @ rim.normal)) < config.parallel:
            straight = replace(rim, tangent=np.cross(normal, rim.normal))
            down = depth_below(rim.point, rim.normal, face, faces, config) * rim.normal
            down = down - float(down @ normal) * normal  # the pad leans a little, and the wall does not
            wall = _between(_along(straight), _along(straight) - down), normal
            _join(found if sure else unsure, wall, config)
    for points, normal in [wall for wall in unsure if _looked_back_at(wall, [*found, *unsure], config)]:
        if not any(_one(wall, (points, normal), 2.0 * config.same, config) for wall in found):
            found.append((points, normal))
    return _contacts(found, config)


def _straight(rim: Sighting, face: int, rims: Sequence[SeenRim], config: RimWallsConfig) -> bool:
    """Whether a rim is too long to be of a circle, unless that is wide and others of the face show it bend."""
    low, high = config.bends
    bent = (
        low < float(other.outward @ rim.outward) < high
        and float(np.linalg.norm(other.point - rim.point)) < config.bent
        for other, own in rims
        if own == face and other.length > config.straight
    )
    return rim.length > config.straight and not any(bent)


def _looked_back_at(wall: Wall, walls: Sequence[Wall], config: RimWallsConfig) -> bool:
    return any(float(wall[1] @ normal) < -config.opposite for _, normal in walls)


def depth_below(
    point: Floats, normal: Floats, own: int, faces: Sequence[Face], config: RimWallsConfig = RimWallsConfig()
) -> float:
    """[mm] from a (3,) rim of face `own` down to the next flat face parallel to it, if one was felt beside it."""
    deep = [config.deep]
    for face in faces:
        if face.id == own or not isinstance(face.fit, Fit) or face.fit.kind != "plane":
            continue
        if abs(float(face.fit.shape.direction @ normal)) > config.known:
            away = point - face.contacts.points
            down = np.median(away @ normal)
            aside = np.linalg.norm(away - np.outer(away @ normal, normal), axis=1)
            deep += [float(down)] if down > 0.0 and aside.min() < config.felt else []
    return min(deep[1:], default=config.deep)


def _directions(faces: Sequence[Face]) -> list[Floats]:
    return [f.fit.shape.direction for f in faces if isinstance(f.fit, Fit) and f.fit.kind == "plane"]


def _turned(faces: Sequence[Face]) -> set[int]:
    return {f.id for f in faces if isinstance(f.fit, Fit) and f.fit.kind != "plane"}


def _join(found: list[Wall], wall: Wall, config: RimWallsConfig) -> None:
    """Add a wall to those found, or to the one of them that it is."""
    for j, (places, known) in enumerate(found):
        if _one((places, known), wall, config.same, config):
            found[j] = (np.concatenate([places, wall[0]]), known)
            return
    found.append(wall)


def _one(first: Wall, second: Wall, within: float, config: RimWallsConfig) -> bool:
    """Whether two walls look the same way, `within` mm of each other."""
    apart = abs(float((first[0].mean(axis=0) - second[0].mean(axis=0)) @ second[1]))
    return bool(first[1] @ second[1] > config.known and apart < within)


def _contacts(walls: Sequence[Wall], config: RimWallsConfig) -> list[Contacts]:
    return [
        Contacts.of(p, np.broadcast_to(n, p.shape), config.sigma, config.normal_sigma, touch=NOT_FELT)
        for p, n in walls
    ]


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
                        out.append((_between(_along(rim), _along(rim) - deep * up), normal))
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
    nearest = max(ways, key=lambda way: abs(float(way @ normal)), default=normal)
    known = abs(float(nearest @ normal)) > config.known
    turned = nearest if known else _upright(a, b, normal, config)
    if turned is None or abs(float(apart @ turned)) > config.coplanar:
        return None
    return np.asarray(turned * np.sign(turned @ normal))


def _upright(a: Sighting, b: Sighting, normal: Floats, config: RimWallsConfig) -> Floats | None:
    """(3,) of a wall straight down from one rim to another that looks the same way; None where it leans."""
    alike = float(a.outward @ b.outward) > config.known and float(a.normal @ b.normal) < -config.known
    if not alike or abs(float(normal @ a.normal)) > config.parallel:
        return None
    upright = a.outward + b.outward
    upright = upright - float(upright @ a.normal) * a.normal
    return np.asarray(upright / np.linalg.norm(upright))


def _along(rim: Sighting) -> Floats:
    """(n, 3) places on a rim."""
    return np.asarray(rim.point + np.outer(np.linspace(-0.4, 0.4, 7), rim.tangent * rim.length))


def _between(a: Floats, b: Floats, config: RimWallsConfig = RimWallsConfig()) -> Floats:
    """(m, 3) places on a wall, beside its rims: from (n, 3) places on one of them toward (n, 3) on another.

    Farther from both something may stand on the wall, or open into it.
    """
    straight = b if (b[-1] - b[0]) @ (a[-1] - a[0]) >= 0.0 else b[::-1]
    far = float(np.linalg.norm(straight - a, axis=1).mean())
    deep = np.minimum(np.array(config.rows) / max(far, 1e-6), 0.4)
    return np.concatenate([(1.0 - share) * a + share * straight for share in (*deep, *(1.0 - deep))])
