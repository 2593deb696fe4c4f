"""Chamfers and roundings of edges, as the pictures of the faces beside them show (`edge_profiles`).

The pictures of both faces tell one size.  A face's own height under each pad is what taxels farther inside say:
the stage errs by more than an edge this small.  Between an end of a turned part and its flank, or round the mouth
of a hole, the end's pictures tell it alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.spatial import KDTree

from exploration.planning.known.mosaic import Mosaic
from exploration.sensing.lines.edge_profiles import DEPTHS, KINDS, Taxels, size_of_edge
from primitives.arrays import Bools, Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.flat_edges import Flat, Stretch, flats, from_wall
from primitives.patch_graph import Face
from primitives.shapes import Cylinder


@dataclass(frozen=True)
class BrokenEdgesConfig:
    """Which edges are looked at, and when one is broken."""

    square: float = 0.15  # most cosine between the normals of two faces
    near: float = 14.0  # [mm] of the edge, that both faces were felt
    ends: float = 2.0  # [mm] left out at either end of an edge
    long: float = 6.0  # [mm] of it, at least
    outside: float = 2.5  # [mm] past an edge, up to which taxels tell,
    inside: float = 5.5  # and inside of it
    own: tuple[float, float] = (6.5, 14.0)  # [mm] inside, where taxels tell how deep the pad lies
    middle: float = 0.7  # of the way to the middle of a narrow one,
    few: int = 3  # of them, at least
    images: int = 40  # of each face, at most
    rounded: float = (
        0.0065  # of chi2 a taxel, that a rounding fits better: it does by 0.001 to 0.006 on chamfers
    )
    past: float = 0.1  # share of a face's contacts, that may lie past an edge where it ends
    upright: float = 0.999  # least cosine between the axis of a cylinder and the face at its end
    coaxial: float = 1.0  # [mm] between axes that are one
    from_end: float = 25.0  # [mm] from that, that the cylinder is known
    round: int = 24  # rows of contacts round that
    rows: int = 12  # of contacts along it,
    across: tuple[float, ...] = (0.06, 0.28, 0.5, 0.72, 0.94)  # of its way from one face to the other
    same: float = 0.6  # [mm] from a face, that is there already,
    alike: float = 0.9  # and least cosine between its normals and theirs
    sigma: float = 0.1  # [mm]
    normal_sigma: float = 0.05  # [rad]


@dataclass(frozen=True)
class BrokenEdge:
    """An edge that is not sharp."""

    kind: str  # "chamfer" or "rounding"
    size: float  # [mm]
    contacts: Contacts
    shape: str  # kind of the face that they are of

    @property
    def told(self) -> str:
        """What a person should know of it."""
        return f"a {self.kind} is inferred from how the pictures of the faces beside it end"


@dataclass(frozen=True)
class _Seen:
    """An edge that is broken: what each kind costs of the size that costs least."""

    sizes: tuple[float, float]  # [mm] of `KINDS`
    apart: float  # of chi2 a taxel, by which a chamfer fits better
    laid: Callable[
        [str, float], tuple[Floats, Floats, str]
    ]  # (n, 3) places, (n, 3) normals, kind of the face

    def as_kind(self, number: int, config: BrokenEdgesConfig) -> BrokenEdge:
        kind, size = KINDS[number], self.sizes[number]
        points, normals, shape = self.laid(kind, size)
        lot = Contacts.of(points, normals, config.sigma, config.normal_sigma, touch=NOT_FELT)
        return BrokenEdge(kind, size, lot, shape)


def broken_edges(
    faces: Sequence[Face], mosaic: Mosaic, config: BrokenEdgesConfig = BrokenEdgesConfig()
) -> list[BrokenEdge]:
    """Those between flat faces, and round the ends of cylinders and holes.

    All are of one kind, as a designer breaks the edges of a part: which of the two one is differs little.
    """
    known = list(flats(faces))
    seen = [edge for pair in combinations(known, 2) if (edge := _straight(*pair, mosaic, config))]
    seen += [
        edge
        for flat in known
        for wall, others in _ending_at(flat, faces, config)
        if (edge := _round(flat, wall, others, mosaic, config))
    ]
    kind = int(bool(seen) and float(np.median([edge.apart for edge in seen])) < -config.rounded)
    made = [edge.as_kind(kind, config) for edge in seen]
    return [edge for edge in made if not any(_is(face, edge.contacts, config) for face in faces)]


def _is(face: Face, lot: Contacts, config: BrokenEdgesConfig) -> bool:
    """Whether a face is where contacts of an edge would be, and looks as they do."""
    if not isinstance(face.fit, Fit):
        return False
    side = 1.0 if face.fit.convex else -1.0
    shape, near = face.fit.shape, KDTree(face.contacts.points).query(lot.points)[0]
    off, facing = (
        np.abs(shape.signed_distance(lot.points)),
        (shape.normals(lot.points) * lot.normals).sum(axis=1),
    )
    there = (off < config.same) & (side * facing > config.alike) & (near < config.near)
    return bool(there.mean() > 0.5)


def _straight(one: Flat, other: Flat, mosaic: Mosaic, config: BrokenEdgesConfig) -> _Seen | None:
    """The edge between two flat faces, if they meet at a convex one and that is broken."""
    if abs(float(one.normal @ other.normal)) > config.square:
        return None
    near, sides = [], ((one, _across(one, other)), (other, _across(other, one)))
    for own, across in sides:
        inside = across(own.felt)
        if np.mean(inside < -config.outside) > config.past:
            return None  # going on past it
        near.append(own.felt[inside < config.near])
    edge = Stretch.of(one, other, near, config.ends)
    if edge is None or edge.length < config.long:
        return None
    told = size_of_edge([_taxels(mosaic, own, across, [], edge.beside, config) for own, across in sides])

    def laid(kind: str, size: float) -> tuple[Floats, Floats, str]:
        rows = edge.rows(config.rows)
        middle = edge.corner - size * (one.normal + other.normal)
        ways, normals, shape = _section(kind, one.normal, other.normal, config)
        points = (middle + rows)[:, None] + size * ways
        return points.reshape(-1, 3), np.tile(normals, (len(rows), 1)), shape

    return None if told is None else _Seen(*told, laid)


def _ending_at(
    end: Flat, faces: Sequence[Face], config: BrokenEdgesConfig
) -> Iterator[tuple[Fit, list[Fit]]]:
    """Each cylinder and hole that ends upright at a flat face, and the others; of those about one axis one."""
    near: list[tuple[float, Fit]] = []
    for face in faces:
        fit = face.fit
        if not isinstance(fit, Fit) or not isinstance(fit.shape, Cylinder):
            continue
        deep = end.offset - face.contacts.points @ end.normal
        upright = abs(float(fit.shape.direction @ end.normal)) > config.upright
        behind = np.mean(deep < -config.outside) < config.past and float(deep.max()) > 0.0
        if upright and behind and float(deep.min()) < config.from_end:
            near.append((float(deep.min()), fit))
    axes, kept = list[tuple[Floats, bool]](), list[Fit]()
    for _, fit in sorted(near, key=lambda one: one[0]):
        at = fit.shape.anchor - float(fit.shape.anchor @ end.normal) * end.normal
        if not any(
            fit.convex == convex and np.linalg.norm(at - other) < config.coaxial for other, convex in axes
        ):
            axes.append((at, fit.convex))
            kept.append(fit)
    for fit in kept:
        yield fit, [other for other in kept if other is not fit]


def _round(
    end: Flat, fit: Fit, others: Sequence[Fit], mosaic: Mosaic, config: BrokenEdgesConfig
) -> _Seen | None:
    """The edge between a flat face and a cylinder or hole that ends there, if it is convex and broken.

    Between two, as on a ring, each has the taxels that are nearer to it.
    """
    shape, side = fit.shape, 1.0 if fit.convex else -1.0
    assert isinstance(shape, Cylinder)

    across, beside = from_wall(fit), [from_wall(other) for other in others]
    inside = across(end.felt)
    if not (inside < config.near).any() or np.mean(inside < -config.outside) > config.past:
        return None
    told = size_of_edge([_taxels(mosaic, end, across, beside, lambda p: np.ones(len(p), dtype=bool), config)])

    def laid(kind: str, size: float) -> tuple[Floats, Floats, str]:
        turns = 2.0 * np.pi * np.arange(config.round) / config.round
        radial = np.column_stack([np.cos(turns), np.sin(turns)]) @ shape.frame[:, :2].T
        foot = shape.anchor + float(end.offset - shape.anchor @ end.normal) * end.normal
        points, normals = list[Floats](), list[Floats]()
        for way in radial:
            ways, out, _ = _section(kind, end.normal, side * way, config)
            middle = foot + (shape.radius - side * size) * way - size * end.normal
            points.append(middle + size * ways)
            normals.append(out)
        return np.concatenate(points), np.concatenate(normals), "cone" if kind == "chamfer" else "torus"

    return None if told is None else _Seen(*told, laid)


def _section(kind: str, one: Floats, other: Floats, config: BrokenEdgesConfig) -> tuple[Floats, Floats, str]:
    """(k, 3) ways from the inner corner of an edge's square to places of it, (k, 3) normals, and its face."""
    share = np.array(config.across)[:, None]
    if kind == "chamfer":
        out = (one + other) / np.linalg.norm(one + other)
        return (1.0 - share) * one + share * other, np.tile(out, (len(share), 1)), "plane"
    ways = np.cos(0.5 * np.pi * share) * one + np.sin(0.5 * np.pi * share) * other
    return ways, ways, "cylinder"


def _across(own: Flat, beside: Flat) -> Callable[[Floats], Floats]:
    """[mm] inside of where another face would meet this one, of (n, 3) places."""
    slope = float(np.linalg.norm(np.cross(own.normal, beside.normal)))
    return lambda places: (beside.offset - places @ beside.normal) / slope


def _taxels(
    mosaic: Mosaic,
    own: Flat,
    across: Callable[[Floats], Floats],
    others: Sequence[Callable[[Floats], Floats]],
    beside: Callable[[Floats], Bools],
    config: BrokenEdgesConfig,
) -> list[Taxels]:
    """Those of every pad that lay on a face and over its end; between two ends, as of a ring, the nearer ones."""
    found = []
    for image in mosaic.flush(own.normal * own.offset, own.normal):
        u, on = across(image.places), beside(image.places)
        nearest = np.min([u, *(other(image.places) for other in others)], axis=0)
        there = (u < config.own[1]) & (image.depth > 0.5 * image.before)
        middle = min(config.own[0], config.middle * float(nearest[there].max(initial=0.0)))
        settled = there & (nearest > middle)
        near = on & (u > -config.outside) & (u < config.inside) & (u <= nearest)
        if settled.sum() < config.few or not near.any():
            continue
        lift = float(np.median(image.depth[settled] - image.before[settled]))
        before = image.before + lift
        near &= (before > DEPTHS[0]) & (before < DEPTHS[-1])
        if near.any():
            found.append(Taxels(u[near], before[near], image.depth[near], image.sigma[near], image.spread))
    return found[:: max(1, len(found) // config.images)]
