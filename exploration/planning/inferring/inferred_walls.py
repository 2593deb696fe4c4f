"""Faces that no pad could lie on, inferred from where they stopped a stroke.

What stops a pad that lies flush on a known face stands up from that face, and the leading side of its housing was
at it.  A single stop tells neither how the wall lies nor that it is flat; but where two stops, from places apart,
agree on one plane across a direction that the object has already, as of a face or an axis, that plane is the
likeliest wall, and what is missing without it is a whole step (our derivation).  The rim that the wall has on
another face says as much as a second stop, and where the wall stands more exactly.  Where as many stops on the
same face, right beside them, lie elsewhere, pads were stopped by what they leant over, as the corners below a
dome, and a few agree by chance; walls that stand beside each other do not deny each other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from exploration.control.sighting import Sighting
from exploration.planning.touching.stops import Stop
from exploration.planning.touching.study import Wall
from primitives.arrays import Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.shapes import Plane


@dataclass(frozen=True)
class InferredWallConfig:
    """When stops are of one plane."""

    flush: float = 0.98  # least cosine between the pad's normal and that of the face that it lay on
    lay: float = 1.5  # [mm] of the pad from that face
    across: float = 0.85  # least cosine between the way that was stopped and the wall's own direction
    upright: float = 0.3  # most cosine between the wall's direction and the face's
    overhang: float = 0.03  # the same against it: a housing that leans over is stopped anywhere up its side
    agree: float = 1.0  # [mm] between stops of one plane
    apart: float = 4.0  # [mm] between the places of two of them
    height: float = 4.0  # [mm] over the face, of where the housing is
    behind: tuple[float, float] = (1.0, 5.0)  # [mm] behind a wall, where its material is
    beside: float = 4.0  # [mm] round a place of the wall, within which an array went through it
    went: int = 2  # places there that it went through, from which there is none
    past: tuple[float, float] = (0.7, 4.0)  # [mm] behind a wall, where its floor was not felt
    stays: float = 0.3  # of the places that must be left
    rival_off: float = 8.0  # [mm] from a wall, up to which stops on the same face deny it,
    rival_beside: float = 16.0  # [mm] from where one of its own was stopped, likewise
    sigma: float = 0.3  # [mm]
    normal_sigma: float = 0.05  # [rad]


def inferred_walls(
    walls: Sequence[Wall],
    faces: Sequence[Face],
    rims: Sequence[Sighting] = (),
    config: InferredWallConfig = InferredWallConfig(),
) -> list[Contacts]:
    """Contacts of each plane that stops agree on, or a stop and one of the `rims` seen of other faces."""
    return _agreeing(stops_of(walls, faces, config), faces, rims, config)


def stops_of(
    walls: Sequence[Wall], faces: Sequence[Face], config: InferredWallConfig = InferredWallConfig()
) -> list[Stop]:
    """What stood upright on a known face where a stroke on it was stopped."""
    fits = [face.fit for face in faces if isinstance(face.fit, Fit)]
    ways = _ways(fits)
    stops: list[Stop] = []
    for wall in walls:
        if not len(ways) or not any(_lies_on(fit, wall, config) for fit in fits):
            continue
        normal = ways[int(np.argmin(ways @ wall.heading))]
        upright = -config.overhang < float(normal @ wall.normal) < config.upright
        if upright and normal @ wall.heading < -config.across:
            stops.append(Stop(wall, normal, _offset(wall, normal)))
    return stops


def standing(
    lot: Contacts, free: Floats, config: InferredWallConfig = InferredWallConfig()
) -> Contacts | None:
    """An inferred wall where no array has been right behind it, at (n, 3) places that hold no material.

    What stopped a stroke beside a gusset's slope was the slope, and the array may have been past it there.
    """
    normal = lot.normals[0]
    depth = float(normal @ lot.points[0]) - free @ normal
    behind = free[(depth > config.behind[0]) & (depth < config.behind[1])]
    if not len(behind):
        return lot
    face = behind + np.outer(normal @ lot.points[0] - behind @ normal, normal)
    near = KDTree(face).query_ball_point(lot.points, config.beside, return_length=True)
    left = lot.select(np.asarray(near) < config.went)
    return left if len(left) >= config.stays * len(lot) else None


def _agreeing(
    stops: list[Stop], faces: Sequence[Face], rims: Sequence[Sighting], config: InferredWallConfig
) -> list[Contacts]:
    lots: list[Contacts] = []
    groups = _groups(stops, faces, config)
    for alike in groups:
        _, normal, offset = alike[0]
        ends = [
            rim.point
            for rim in rims
            if rim.outward @ normal > config.flush and abs(float(normal @ rim.point) - offset) < config.agree
        ]
        if not _are_apart([*(wall.pose[:3, 3] for wall, _, _ in alike), *ends], config):
            continue
        if not ends and _by_chance(alike, groups, faces, config):
            continue
        told = [float(normal @ point) for point in ends] or [offset for *_, offset in alike]
        at = float(np.median(told))  # a rim that was seen tells it nearer than a housing that was stopped
        points = np.concatenate([_places(wall, normal, at, config) for wall, _, _ in alike])
        normals = np.broadcast_to(normal, points.shape)
        lots.append(Contacts.of(points, normals, config.sigma, config.normal_sigma, touch=NOT_FELT))
    return lots


def _groups(stops: list[Stop], faces: Sequence[Face], config: InferredWallConfig) -> list[list[Stop]]:
    """Stops of about one plane each, every stop in one of them."""
    groups: list[list[Stop]] = []
    while stops:
        _, normal, offset = stops[0]
        alike = [
            s for s in stops if s.normal @ normal > config.flush and abs(s.offset - offset) < config.agree
        ]
        groups.append(_unparted(alike, faces, config))
        stops = [s for s in stops if not any(s is other for other in groups[-1])]
    return groups


def _are_apart(places: Sequence[Floats], config: InferredWallConfig) -> bool:
    return float(np.linalg.norm(np.array(places) - places[0], axis=1).max()) >= config.apart


def _by_chance(
    alike: list[Stop], groups: list[list[Stop]], faces: Sequence[Face], config: InferredWallConfig
) -> bool:
    """Whether as many stops of other groups, but those of walls beside this one, lie right beside its own."""
    at, floors = float(np.median([stop.offset for stop in alike])), _floors(alike, faces, config)

    def denies(stop: Stop) -> bool:
        return bool(
            stop.normal @ alike[0].normal > config.flush
            and config.agree < abs(stop.offset - at) < config.rival_off
            and _floors([stop], faces, config) & floors
            and any(np.linalg.norm(stop.wall.point - own.wall.point) < config.rival_beside for own in alike)
        )

    others = [group for group in groups if group is not alike and not _stands_beside(group, alike, config)]
    return sum(denies(stop) for group in others for stop in group) >= len(alike)


def _stands_beside(group: list[Stop], other: list[Stop], config: InferredWallConfig) -> bool:
    """Whether stops are of a wall of their own, that ends before another begins."""
    own, others = (
        np.array([stop.wall.pose[:3, 3] @ other[0].along for stop in lot]) for lot in (group, other)
    )
    apart = bool(own.max() < others.min() or others.max() < own.min())
    return apart and _are_apart([stop.wall.pose[:3, 3] for stop in group], config)


def _floors(stops: Sequence[Stop], faces: Sequence[Face], config: InferredWallConfig) -> set[int]:
    """Indices of the faces that pads lay on."""
    return {
        n
        for n, face in enumerate(faces)
        if isinstance(face.fit, Fit) and any(_lies_on(face.fit, stop.wall, config) for stop in stops)
    }


def _unparted(stops: list[Stop], faces: Sequence[Face], config: InferredWallConfig) -> list[Stop]:
    """Of stops at one plane those with no wall missing between them and the first.

    Bosses in the corners of a box stop strokes along its floor in one plane, and the floor goes on between them.
    """
    along = stops[0].along
    behind = _felt_behind(stops[0], faces, config)
    where = np.array([stop.wall.pose[:3, 3] @ along for stop in stops])
    low, high = np.minimum(where, where[0]), np.maximum(where, where[0])
    between = ((behind > low[:, None]) & (behind < high[:, None])).any(axis=1)
    return [stop for stop, parted in zip(stops, between, strict=True) if not parted]


def _felt_behind(stop: Stop, faces: Sequence[Face], config: InferredWallConfig) -> Floats:
    """(n,) [mm] along a wall, where the face that it stands on was felt right behind it."""
    there = [np.empty(0)]
    for face in faces:
        if isinstance(face.fit, Fit) and _lies_on(face.fit, stop.wall, config):
            felt = face.contacts.points[face.contacts.touch != NOT_FELT]
            depth = stop.offset - felt @ stop.normal
            there.append(felt[(depth > config.past[0]) & (depth < config.past[1])] @ stop.along)
    return np.concatenate(there)


def _ways(fits: Sequence[Fit]) -> Floats:
    """(n, 3) directions of the object's flat faces and axes, both ways."""
    out: list[Floats] = []
    for fit in fits:
        direction = getattr(fit.shape, "direction", None)
        if direction is not None:
            out += [
                np.asarray(sign * direction)
                for sign in (1.0, -1.0)
                if all(sign * (direction @ o) < 0.995 for o in out)
            ]
    return np.array(out).reshape(-1, 3)


def _lies_on(fit: Fit, wall: Wall, config: InferredWallConfig) -> bool:
    at = wall.pose[None, :3, 3]
    side = 1.0 if fit.convex or isinstance(fit.shape, Plane) else -1.0
    normal = side * fit.shape.normals(at)[0]
    if isinstance(fit.shape, Plane):
        normal = np.sign(normal @ wall.normal) * normal
    near = abs(float(fit.shape.signed_distance(at)[0])) < config.lay
    return near and float(normal @ wall.normal) > config.flush


def _offset(wall: Wall, normal: Floats) -> float:
    """[mm] along a wall's normal, of the housing's corner that was nearest to it."""
    reach = float(np.abs(normal @ wall.pose[:3, :2]) @ wall.half)
    return float(normal @ wall.pose[:3, 3]) - reach


def _places(wall: Wall, normal: Floats, offset: float, config: InferredWallConfig) -> Floats:
    """(3, 3) where the housing stood along the wall."""
    foot = wall.pose[:3, 3] + config.height * wall.normal
    foot = foot + (offset - float(normal @ foot)) * normal
    along = np.cross(wall.normal, normal)
    along = along / np.linalg.norm(along)
    up = np.cross(normal, along)
    return np.array([foot, foot + config.height * along + up, foot - config.height * along + up])
