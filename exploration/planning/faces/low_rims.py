"""Round rims so low that every touch of one read as a flat of its own, taken together.

A pad on the rim of a low disc feels a strip a few taxels wide, which bends no more than its own blur.  Flats at
p_i with normals n_i are tangents of one circle where

    c + r n_i = p_i,

three unknowns and two equations for each: three flats are enough to say that they are not (our derivation).  The
sides of a regular polygon, felt in their middles, are tangents of one circle as well; but they look only so many
ways.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from exploration.planning.faces.uprighted import bent, directions, drawn_out
from primitives.arcs import around
from primitives.arrays import Floats, frozen
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit, fit, squares
from primitives.patch_graph import Face, PatchGraph
from primitives.pose import frame_along

_ASIDE = 0.15  # of the weight of a distance, that of a place along a tangent


@dataclass(frozen=True)
class LowRimsConfig:
    """When flats are pieces of a rim."""

    few: int = 10  # contacts of one at most
    low: float = 8.0  # [mm] along the rim's axis, that all of them lie within
    across: float = 0.1  # most cosine between the axis and the way that one looks
    level: float = 3.0  # [mm] along it, from the middle of one to that of another at most
    least: int = 3  # flats
    off: float = 0.25  # [mm] of one from the circle,
    aside: float = 1.2  # and along it from where the circle has its normal
    radii: tuple[float, float] = (4.0, 60.0)  # [mm]
    around: float = 2.0  # [rad] of the circle, over which they are
    sides: tuple[int, ...] = (3, 4, 5, 6)  # of polygons; of more, a circle is as good
    turned: float = 0.09  # [rad] of any flat from the ways that a polygon's sides look, to be none of them
    rms: float = 0.12  # [mm] of all contacts from the rim


@dataclass(frozen=True)
class _Flat:
    """One of them, seen along the axis."""

    face: Face
    place: Floats  # (2,) [mm]
    normal: Floats  # (2,)
    level: float  # [mm]


def whole_rims(
    graph: PatchGraph, config: LowRimsConfig = LowRimsConfig()
) -> tuple[PatchGraph, dict[int, int]]:
    """The graph with one upright cylinder for the flats of each such rim, and whose ids it has taken."""
    faces, gone = list(graph.faces), dict[int, int]()
    for way in directions(graph):
        flats = list(_flats(faces, way, config))
        while (found := _rim(flats, way, config)) is not None:
            rim, own = found
            flats = [flat for flat in flats if all(flat is not other for other in own)]
            gone |= {flat.face.id: rim.id for flat in own if flat.face.id != rim.id}
            faces = [rim if face.id == rim.id else face for face in faces if face.id not in gone]
    return (replace(graph, faces=tuple(faces)) if gone else graph), gone


def _flats(faces: Sequence[Face], way: Floats, config: LowRimsConfig) -> Iterator[_Flat]:
    """Small flat faces that look across a (3,) way."""
    turn = frame_along(way)
    for face in faces:
        felt = face.contacts
        small = isinstance(face.fit, Fit) and face.fit.kind == "plane" and len(felt) <= config.few
        if not small or (felt.touch == NOT_FELT).any() or not np.isfinite(felt.normals).all():
            continue
        places, normal = felt.points @ turn, felt.normals.mean(axis=0) @ turn
        if np.ptp(places[:, 2]) < config.low and abs(normal[2]) < config.across:
            place = places.mean(axis=0)
            yield _Flat(face, place[:2], normal[:2] / np.linalg.norm(normal[:2]), float(place[2]))


def _rim(flats: Sequence[_Flat], way: Floats, config: LowRimsConfig) -> tuple[Face, list[_Flat]] | None:
    """The rim of the most flats, and those; of as many, the one that they fit best."""
    best: tuple[int, float] = (config.least - 1, 0.0)
    found: tuple[Face, list[_Flat]] | None = None
    for three in combinations(flats, 3):
        if max(flat.level for flat in three) - min(flat.level for flat in three) > config.level:
            continue
        center, radius = _circle(three)
        if not config.radii[0] < radius < config.radii[1]:
            continue
        level = [flat for flat in flats if abs(flat.level - three[0].level) < config.level]
        own = [flat for flat in level if _is_on(flat, center, radius, config)]
        rim = _made(own, center, way, config) if len(own) >= max(best[0], config.least) else None
        if rim is not None and isinstance(rim.fit, Fit) and (len(own), -rim.fit.rms) > best:
            best, found = (len(own), -rim.fit.rms), (rim, own)
    return found


def _circle(flats: Sequence[_Flat]) -> tuple[Floats, float]:
    """(2,) center [mm] and radius of the circle that flats are tangents of, as nearly as they are.

    Where along its tangent a flat touches the circle says little beside how far off that is.
    """
    normals = np.array([flat.normal for flat in flats])
    alongs = np.column_stack([-normals[:, 1], normals[:, 0]])
    places = np.array([flat.place for flat in flats])
    rows = np.column_stack([normals, np.ones(len(flats))])
    beside = _ASIDE * np.column_stack([alongs, np.zeros(len(flats))])
    told = np.concatenate([(normals * places).sum(axis=1), _ASIDE * (alongs * places).sum(axis=1)])
    solved = np.linalg.lstsq(np.concatenate([rows, beside]), told)[0]
    return solved[:2], float(solved[2])


def _is_on(flat: _Flat, center: Floats, radius: float, config: LowRimsConfig) -> bool:
    away = flat.place - center - radius * flat.normal
    along = np.array([-flat.normal[1], flat.normal[0]])
    return bool(abs(away @ flat.normal) < config.off and abs(away @ along) < config.aside)


def _made(own: Sequence[_Flat], center: Floats, way: Floats, config: LowRimsConfig) -> Face | None:
    """The cylinder through all contacts of some flats, where they are no polygon's sides."""
    angles = np.array([np.arctan2(*(flat.place - center)[::-1]) for flat in own])
    if around(angles) < config.around or any(_of_polygon(own, n, config) for n in config.sides):
        return None
    felt = Contacts.concatenate([flat.face.contacts for flat in own])
    told = bent(felt)
    made = fit("cylinder", drawn_out(told, way))
    if not isinstance(made, Fit) or not made.convex or made.rms > config.rms:
        return None
    chi2, every = float(squares(made, told).sum()), frozen(np.ones(len(felt)), bool)
    whole = replace(made, inliers=every, chi2=chi2, dof=3 * len(felt) - 3)
    return replace(own[0].face, fit=whole, contacts=felt, ranked=())


def _of_polygon(own: Sequence[_Flat], sides: int, config: LowRimsConfig) -> bool:
    """Whether all look only the ways that the sides of a regular polygon do."""
    ways = np.array([np.arctan2(flat.normal[1], flat.normal[0]) for flat in own])
    turned = np.exp(1j * sides * ways)
    return bool(np.abs(np.angle(turned / turned.mean())).max() < sides * config.turned)
