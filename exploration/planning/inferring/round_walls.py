"""Round walls that no array has room to face, inferred from where the flat face at their end ends.

Edges of one flat face that all look away from one point, equally far from it, are pieces of a circle, and what
stands below that is round: a wheel's hub, a boss.  Where no edges were made out, as on a ring so narrow that two
of them are under the pad, the places serve at which the face was felt last, and less well.  n places are fitted by

    |x|^2 = 2 c . x + (r^2 - |c|^2),

linear in c and in the bracket (Kasa 1976).  Edges of a square or a hexagon may lie so, too, in the middles of its
sides; but then they look only so many ways (our derivation).

A disc that has notches ends at other places as well.  Its circle is one through three corners of the face's convex
hull that holds all of the face, and that most of the ways out of its middle end at (compare Fischler and Bolles
1981; our derivation).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import ConvexHull

from exploration.control.sighting import Sighting
from exploration.planning.inferring.upright_walls import depth_below
from exploration.planning.known.surface_map import clusters
from exploration.planning.open.known_face import KnownFace
from exploration.planning.touching.findings import SeenRim
from primitives.arcs import around, circle_through
from primitives.arrays import Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.patch_graph import Face
from primitives.pose import frame_along
from primitives.shapes import Cylinder


@dataclass(frozen=True)
class Likeness:
    """When places are of one circle."""

    least: int  # of them
    off: float  # [mm] from the circle
    away: float  # least cosine between the way out of the face there and the way from the middle


@dataclass(frozen=True)
class RoundWallsConfig:
    """What tells of a circle, and where its wall is."""

    edges: Likeness = Likeness(4, 0.5, 0.95)  # as looks have shown them
    ends: Likeness = Likeness(16, 1.5, 0.3)  # where the face was felt last: ways out are hardly known
    round: float = 0.08  # of the radius, that a place may be off it at most
    share: float = 0.75  # of a face's places that must be of it
    apart: float = 8.0  # [mm] between pieces of a face, each of which may have a circle of its own,
    cells: int = 12  # felt places of one at least
    held: Likeness = Likeness(24, 1.5, 0.3)  # the same, where a circle holds all of a face
    past: float = 1.2  # [mm] past such a circle, which the blur of what was felt reaches at most
    stray: tuple[float, float] = (0.01, 0.1)  # share of the face's places that may lie farther out; of edges'
    tried: int = 300  # threes of its outermost places, through which a circle is laid
    sectors: int = 72  # of a turn
    filled: float = 0.6  # share of them in which the face ends at it
    bare: float = 0.6  # share of the places where the face was felt last, that no other face may explain
    around: float = 3.3  # [rad] of it, over which they are
    turned: float = 0.05  # [rad] from the ways that a polygon's edges look, to be none of them
    sides: tuple[int, ...] = (4, 6)  # of such polygons
    parallel: float = 0.998  # least cosine between the axes of two ends of one wall
    same: float = 0.8  # [mm] between the axes of a circle and a cylinder that ends at it, and their radii
    upright: float = 0.1  # most cosine between the way out of an edge and the face's own
    behind: tuple[float, float] = (1.0, 5.0)  # [mm] behind a wall, where its material is
    went: int = 4  # places there that an array went through, from which there is none
    rows: tuple[float, ...] = (0.5, 1.2, 2.5)  # [mm] below the edge, where the wall is
    inside: float = 0.4  # of the wall's depth, likewise at most
    land: float = 5.0  # [mm] of it, that there is at least
    ring: int = 24  # places round it
    sigma: float = 0.5  # [mm]
    normal_sigma: float = 0.05  # [rad]


@dataclass(frozen=True)
class Circle:
    """The outline of a flat face."""

    center: Floats  # (3,) [mm]
    axis: Floats  # (3,) out of the face
    radius: float  # [mm]
    notched: bool = False  # whether the face ends inside it, too

    def places(self, count: int = 12) -> Floats:
        """(count, 3) [mm] on it."""
        turn = 2.0 * np.pi * np.arange(count) / count
        ways = np.column_stack([np.cos(turn), np.sin(turn)]) @ frame_along(self.axis)[:, :2].T
        return np.asarray(self.center + self.radius * ways)


def round_walls(
    rims: Sequence[SeenRim],
    known: Sequence[KnownFace],
    open_: Sequence[tuple[Floats, Floats]],
    free: Floats,
    config: RoundWallsConfig = RoundWallsConfig(),
) -> list[Contacts]:
    """Contacts of the round wall below each flat face whose unexplained edges are a circle's.

    `open_[k]` are (n, 3) places at which the `known` face k was felt last, and no face explains it, with the ways
    out of it there.  An array was at (m, 3) places `free`.
    """
    faces, found = [own.face for own in known], list[tuple[Circle, float]]()
    for own, (at, out) in zip(known, open_, strict=True):
        if own.fit.kind != "plane":
            continue
        axis = own.side * own.fit.shape.direction
        seen = [
            rim
            for rim, face in rims
            if face == own.face.id and abs(float(rim.outward @ axis)) < config.upright
        ]
        whole = _outline(own, seen, at, out, config)
        pieces = [] if whole else _apart(own, seen, at, out, config)
        for circle in [whole] if whole else [_outline(*piece, config) for piece in pieces]:
            if circle is None or any(_is_end(circle, wall, config) for wall in known):
                continue
            if (deep := _deep(circle, own.face.id, faces, free, config)) > 0.0:
                found.append((circle, deep))
    return [
        _wall(_one_of(circle, [other for other, _ in found], config), deep, config) for circle, deep in found
    ]


def _apart(
    own: KnownFace, seen: Sequence[Sighting], at: Floats, out: Floats, config: RoundWallsConfig
) -> Iterator[tuple[KnownFace, list[Sighting], Floats, Floats]]:
    """The pieces of a face, as the feet of a frame are, each with the edges seen of it and where it ended."""
    masks = clusters(own.cells, config.apart)
    if len(masks) < 2:
        return
    piece = np.argmax(masks, axis=0)
    edges = piece[own.near.query(np.array([rim.point for rim in seen]).reshape(-1, 3))[1]]
    ends = piece[own.near.query(at)[1]]
    for k, mask in enumerate(masks):
        if mask.sum() >= config.cells:
            beside = [rim for rim, of in zip(seen, edges, strict=True) if of == k]
            yield replace(own, cells=own.cells[mask]), beside, at[ends == k], out[ends == k]


def _outline(
    own: KnownFace, seen: Sequence[Sighting], at: Floats, out: Floats, config: RoundWallsConfig
) -> Circle | None:
    """The circle of edges `seen` of a face, or of (n, 3) places `at` which it was felt last, or that holds it."""
    axis = own.side * own.fit.shape.direction
    edges = np.array([rim.point for rim in seen]).reshape(-1, 3)
    ways = np.array([rim.outward for rim in seen]).reshape(-1, 3)
    circle = _circle(edges, ways, axis, config.edges, config)
    if circle is not None and not _holds(circle, own.cells, config):
        circle = None
    if circle is None and len(at) > config.bare * len(own.rim[0]):
        circle = _circle(at, out, axis, config.ends, config)
    return circle or _holding(own.cells, at, axis, config)


def _is_end(circle: Circle, wall: KnownFace, config: RoundWallsConfig) -> bool:
    """Whether a circle is the end of a cylinder that was felt beside it; corners of facets lie farther out."""
    shape = wall.fit.shape
    if not isinstance(shape, Cylinder) or wall.side < 0.0 or not len(wall.cells):
        return False
    away = circle.center - shape.anchor
    aside = float(np.linalg.norm(away - float(away @ shape.direction) * shape.direction))
    beside = np.abs((wall.cells - circle.center) @ circle.axis).min() < config.land
    alike = max(aside, abs(circle.radius - shape.radius)) < config.same
    return bool(beside and alike and abs(float(circle.axis @ shape.direction)) > config.parallel)


def _holds(circle: Circle, cells: Floats, config: RoundWallsConfig) -> bool:
    """Whether a circle holds a face felt at (n, 3) cells: edges of letters in it may look out of one, too."""
    away = cells - circle.center
    far = np.linalg.norm(away - np.outer(away @ circle.axis, circle.axis), axis=1)
    return int((far > circle.radius + config.past).sum()) <= config.stray[1] * len(far)


def _deep(circle: Circle, own: int, faces: Sequence[Face], free: Floats, config: RoundWallsConfig) -> float:
    """[mm] that the wall below an outline goes down, 0 where an array was behind it."""
    below = [depth_below(place, circle.axis, own, faces) for place in circle.places()]
    deep = float(np.median(below))  # at its edge: in its middle may be a bore
    if _gone_through(circle, (config.land, deep - config.land), free, config):
        deep = config.land
    return 0.0 if _gone_through(circle, (0.0, min(config.land, deep)), free, config) else deep


def _one_of(circle: Circle, others: Sequence[Circle], config: RoundWallsConfig) -> Circle:
    """The circle, as round as the first of all that are ends of one wall."""
    for other in others:
        away = circle.center - other.center
        aside = away - float(away @ other.axis) * other.axis
        near = abs(circle.radius - other.radius) < config.ends.off and np.linalg.norm(aside) < config.ends.off
        if near and abs(float(circle.axis @ other.axis)) > config.parallel:
            return replace(circle, center=circle.center - aside, radius=other.radius)
    return circle


def _circle(
    at: Floats, out: Floats, axis: Floats, alike: Likeness, config: RoundWallsConfig
) -> Circle | None:
    """The circle that most of (n, 3) places lie on, all looking away from its middle; None where there is none."""
    if len(at) < alike.least:
        return None
    turn = frame_along(axis)
    places, ways = at @ turn, (out @ turn)[:, :2]
    outer = ((places[:, :2] - _through(places[:, :2])[0]) * ways).sum(axis=1) > 0.0  # the others are a bore's
    places, ways, kept = places[outer], ways[outer], np.ones(int(outer.sum()), dtype=bool)
    while kept.sum() >= max(alike.least, config.share * len(places)):
        center, radius = _through(places[kept, :2])
        from_middle = places[:, :2] - center
        far = np.linalg.norm(from_middle, axis=1)
        cosine = (from_middle * ways).sum(axis=1) / np.maximum(far, 1e-9)
        amiss = np.abs(far - radius) / min(alike.off, config.round * radius) + np.where(
            cosine < alike.away, 1.0, 0.0
        )
        if amiss[kept].max() < 1.0:
            angle = np.sort(np.arctan2(from_middle[kept, 1], from_middle[kept, 0]))
            if around(angle) < config.around or any(_of_polygon(angle, n, config) for n in config.sides):
                return None
            return Circle(turn @ np.array([*center, float(places[kept, 2].mean())]), axis, radius)
        kept[np.argmax(np.where(kept, amiss, -1.0))] = False
    return None


def _holding(cells: Floats, at: Floats, axis: Floats, config: RoundWallsConfig) -> Circle | None:
    """The circle that holds a face felt at (n, 3) cells, and that most ways out of it end at (m, 3) places of."""
    turn = frame_along(axis)
    flat, ends = (cells @ turn)[:, :2], (at @ turn)[:, :2]
    if len(ends) < config.held.least:
        return None
    corners = flat[ConvexHull(flat).vertices]
    best, found, rng = config.filled * config.sectors, None, np.random.default_rng(0)
    for _ in range(config.tried):
        center, radius = _through(corners[rng.choice(len(corners), 3, replace=False)])
        far = np.linalg.norm(flat - center, axis=1)
        if np.isfinite(radius) and np.mean(far > radius + config.past) < config.stray[0]:
            on = np.abs(np.linalg.norm(ends - center, axis=1) - radius) < config.held.off
            count = _sectors(ends[on] - center, config)
            if count > best and around(_angles(ends[on] - center)) > config.around:
                best, found = count, on
    if found is None:
        return None
    center, radius = _through(ends[found])
    level = float((cells @ turn)[:, 2].mean())
    return Circle(turn @ np.array([*center, level]), axis, radius, notched=True)


def _sectors(from_middle: Floats, config: RoundWallsConfig) -> int:
    share = _angles(from_middle) / (2.0 * np.pi) + 0.5
    return len(np.unique(np.floor(share * config.sectors)))


def _angles(from_middle: Floats) -> Floats:
    return np.asarray(np.arctan2(from_middle[:, 1], from_middle[:, 0]))


def _through(flat: Floats) -> tuple[Floats, float]:
    """(2,) center and radius of the circle nearest to (n, 2) places; a line's is endless."""
    middle = flat.mean(axis=0)
    found = circle_through(flat - middle)
    return (middle, np.inf) if found is None else (middle + found[0], found[1])


def _of_polygon(angle: Floats, sides: int, config: RoundWallsConfig) -> bool:
    """Whether all look only the ways that the sides of a regular polygon do."""
    turned = (angle - angle[0]) * sides / (2.0 * np.pi)
    return bool(np.abs(turned - np.round(turned)).max() * 2.0 * np.pi / sides < config.turned)


def _gone_through(
    circle: Circle, between: tuple[float, float], free: Floats, config: RoundWallsConfig
) -> bool:
    """Whether an array was behind the wall `between` two depths [mm], as in a groove round it.

    In the notches of a circle that has some it may have been.
    """
    away = free - circle.center
    down = -away @ circle.axis
    behind = circle.radius - np.linalg.norm(away + np.outer(down, circle.axis), axis=1)
    low, high = config.behind
    went = (down > between[0]) & (down < between[1]) & (behind > low) & (behind < high)
    if circle.notched:
        return (
            _sectors(away[went] @ frame_along(circle.axis), config) > (1.0 - config.filled) * config.sectors
        )
    return int(went.sum()) >= config.went


def _wall(circle: Circle, deep: float, config: RoundWallsConfig) -> Contacts:
    """Contacts of a wall so many [mm] deep, looking out; nobody felt it."""
    turn = 2.0 * np.pi * np.arange(config.ring) / config.ring
    ways = np.column_stack([np.cos(turn), np.sin(turn)]) @ frame_along(circle.axis)[:, :2].T
    ring = circle.center + circle.radius * ways
    below = np.minimum(config.rows, config.inside * deep).tolist()
    rows = [*below, *(deep - row for row in below if deep > config.land)]
    points = np.concatenate([ring - row * circle.axis for row in rows])
    normals = np.tile(ways, (len(rows), 1))
    return Contacts.of(points, normals, config.sigma, config.normal_sigma, touch=NOT_FELT)
