"""Hulls and Minkowski sums that have an exact form here.

The hull of discs, and of corners, which are discs of radius zero, is the union of the discs on its rim and of the
polygon through the points where its straight sides touch them (our derivation); the sum of a convex polygon and a
disc is the hull of discs at the corners.  The hull of flat-sided solids is that of their corners.  Upright bars,
boxes and prisms of one height hull like their outlines.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

import numpy as np

from models.csg import (
    Cone,
    Csg,
    Cube,
    Cylinder,
    Operation,
    Placed,
    Polyhedron,
    Primitive,
    Prism,
    Sphere,
    Union,
)
from models.formats.openscad import sizes
from models.formats.openscad.balls import hull_of_balls
from models.formats.openscad.flat import Combined, Disc, Flat, Outline
from models.formats.openscad.hulls import convex_corners, convex_faces
from models.formats.openscad.revolve import turned_outline
from models.formats.openscad.shapes import Shape
from models.formats.openscad.sided import outside
from models.leaves.polygons import cleaned
from primitives.arrays import Floats
from primitives.errors import PalpateError
from primitives.pose import inverse, pose, transform_points

_SAME = 1e-6  # of the size: lengths and directions this close are one
_MOST = 150  # circles and corners of one hull


def hull_of_solids(shape: Shape, trees: Sequence[Csg]) -> Csg:
    """The hull of solids that are flat-sided all, or upright bars of one kind."""
    leaves = [leaf for tree in trees for leaf in _leaves(tree, np.eye(4))]
    if len(leaves) == 1:
        return trees[0]
    if leaves and all(isinstance(p, Cube | Prism | Polyhedron) for p, _ in leaves):
        return _hull(np.concatenate([transform_points(m, outside(p)[0]) for p, m in leaves]))  # type: ignore[arg-type]
    balls = [(p, m) for p, m in leaves if isinstance(p, Sphere)]
    if (
        leaves
        and len(balls) == len(leaves)
        and np.ptp([p.radius for p, _ in balls]) <= _SAME * balls[0][0].radius
    ):
        return hull_of_balls(np.array([m[:3, 3] for _, m in balls]), balls[0][0].radius)
    if (flats := _upright(leaves)) is not None:
        (bar, home) = next((p, m) for p, m in leaves if isinstance(p, Cylinder))
        return _bars(hull_of_flats(shape, flats), bar.height).placed(home)
    if leaves and (profile := _common_profile(leaves)) is not None:
        return turned_outline(Outline(convex_corners(profile))).placed(leaves[0][1])
    raise shape.error(
        "hull() of these has no exact form here; use flat-sided solids, balls of one radius, or what is upright"
    )


def hull_of_flats(shape: Shape, flats: Sequence[Flat]) -> Flat:
    """The hull of polygons and discs."""
    leaves = [leaf for flat in flats for leaf in _flat_leaves(flat)]
    discs = [leaf for leaf in leaves if isinstance(leaf, Disc)]
    outlines = [leaf.corners for leaf in leaves if isinstance(leaf, Outline)]
    if len(leaves) == 1 and discs:
        return discs[0]
    corners = convex_corners(np.concatenate(outlines)) if outlines else np.empty((0, 2))
    if not discs:
        return Outline(corners)
    if len(discs) + len(corners) > _MOST:
        raise shape.error(f"hull() of more than {_MOST} circles and corners is not read; use fewer")
    centers = np.concatenate([corners, *(disc.center[None] for disc in discs)])
    return _wrapped(centers, np.array([0.0] * len(corners) + [disc.radius for disc in discs]))


def sum_of_flats(shape: Shape, flats: Sequence[Flat]) -> Flat:
    """The Minkowski sum of a convex polygon and a disc, or of two convex polygons."""
    if len(flats) == 2 and all(isinstance(flat, Disc | Outline) for flat in flats):
        first, second = sorted(flats, key=lambda flat: isinstance(flat, Disc))
        if isinstance(first, Outline) and len(convex_corners(first.corners)) == len(cleaned(first.corners)):
            if isinstance(second, Disc):
                return _rounded(first.corners + second.center, second.radius)
            if isinstance(second, Outline) and len(convex_corners(second.corners)) == len(
                cleaned(second.corners)
            ):
                return Outline(convex_corners((first.corners[:, None] + second.corners).reshape(-1, 2)))
    raise shape.error("minkowski() of these has no exact form here; sum a convex polygon and a circle")


def offset(shape: Shape, flat: Flat) -> Flat:
    """`offset` of a disc or a convex polygon."""
    away = sizes.number(shape, "delta" if shape.arguments.get("delta") is not None else "r", 1.0)
    if isinstance(flat, Disc) and flat.radius + away > 0:
        return Disc(flat.center, flat.radius + away, flat.label)
    sharp = away <= 0 or shape.arguments.get("delta") is not None
    if isinstance(flat, Outline) and not shape.arguments.get("chamfer"):
        corners = cleaned(flat.corners)
        if len(convex_corners(corners)) == len(corners):
            if not sharp:
                return _rounded(corners, away)
            moved = _moved_sides(corners, away)
            if moved is not None:
                return Outline(moved, flat.label)
    raise shape.error("offset() of this has no exact form here; use it on a circle or a convex polygon")


def sum_of_solids(shape: Shape, trees: Sequence[Csg]) -> Csg:
    """The Minkowski sum of two convex flat-sided solids, or of an upright box and an upright bar."""
    leaves = [leaf for tree in trees for leaf in _leaves(tree, np.eye(4))]
    if len(trees) == len(leaves) == 2:
        (first, a), (second, b) = sorted(leaves, key=lambda leaf: isinstance(leaf[0], Cylinder | Sphere))
        if isinstance(first, Cube) and isinstance(second, Sphere):
            return hull_of_balls(transform_points(a, outside(first)[0]) + b[:3, 3], second.radius)
        upright = np.array_equal(a[:3, :3], np.eye(3)) and abs(b[2, 2]) > 1 - _SAME
        if isinstance(first, Cube) and isinstance(second, Cylinder) and upright:
            x, y, z = first.size
            centers = np.array([(i * x / 2, j * y / 2) for i in (-1, 1) for j in (-1, 1)])
            bar = _bars(_rounded(centers, second.radius), z + second.height)
            return bar.placed(pose(None, a[:3, 3] + b[:3, 3]))
        if _is_convex(first) and _is_convex(second):
            p, q = (transform_points(m, outside(c)[0]) for c, m in ((first, a), (second, b)))  # type: ignore[arg-type]
            return _hull((p[:, None] + q).reshape(-1, 3))
    raise shape.error("minkowski() of these has no exact form here; sum a cube and one more solid")


def _is_convex(primitive: Primitive) -> bool:
    """Whether it is flat-sided and lies behind all of its faces."""
    if not isinstance(primitive, Cube | Prism | Polyhedron):
        return False
    corners, faces = outside(primitive)
    size = float(np.ptp(corners, axis=0).max())
    for face in faces:
        rim = corners[list(face)]
        normal = np.cross(rim - rim[0], np.roll(rim, -1, axis=0) - rim[0]).sum(axis=0)  # Newell
        if float(((corners - rim[0]) @ normal).max()) > _SAME * size * float(np.linalg.norm(normal)):
            return False
    return True


def _rounded(centers: Floats, radius: float) -> Flat:
    """The hull of discs round (n, 2) centers."""
    return _wrapped(centers, np.full(len(centers), radius))


def _wrapped(centers: Floats, radii: Floats) -> Flat:
    """The hull of discs of (n,) radii round (n, 2) centers; a corner is a disc of none."""
    size = float(np.ptp(centers, axis=0).max() + radii.max())
    _, first = np.unique(
        np.round(np.column_stack([centers, radii]) / (_SAME * size)), axis=0, return_index=True
    )
    centers, radii = centers[np.sort(first)], radii[np.sort(first)]
    sides: dict[float, tuple[float, int, int, Floats]] = {}  # by the way that they look, the longest of each
    for i, j in permutations(range(len(centers)), 2):
        along = centers[j] - centers[i]
        far = float(np.linalg.norm(along))
        if far <= abs(radii[i] - radii[j]) + _SAME * size:
            continue  # one holds the other
        along, lean = along / far, float(radii[i] - radii[j]) / far
        normal = lean * along + np.sqrt(1.0 - lean**2) * np.array([along[1], -along[0]])
        if (centers @ normal + radii).max() > centers[i] @ normal + radii[i] + _SAME * size:
            continue
        way = round(float(np.arctan2(normal[1], normal[0])) % (2.0 * np.pi), 6) % round(2.0 * np.pi, 6)
        sides[way] = max(sides.get(way, (0.0, i, j, normal)), (far, i, j, normal), key=lambda side: side[0])
    if not sides:
        largest = int(np.argmax(radii))
        return Disc(centers[largest], float(radii[largest]))
    wound = [sides[way] for way in sorted(sides)]
    rim = np.array([centers[k] + radii[k] * normal for _, *ends, normal in wound for k in ends])
    round_ones = sorted({k for _, *ends, _ in wound for k in ends if radii[k] > 0.0})
    return Combined(
        "union", (Outline(cleaned(rim)), *(Disc(centers[k], float(radii[k])) for k in round_ones))
    )


def _upright(leaves: Sequence[tuple[Primitive, Floats]]) -> list[Flat] | None:
    """Bars, boxes and prisms along one bar's axis and as long as it, as flat shapes across it; else None."""
    home = next((m for p, m in leaves if isinstance(p, Cylinder)), None)
    if home is None:
        return None
    flats: list[Flat] = []
    ends: list[tuple[float, float]] = []
    for primitive, placed in leaves:
        moved = inverse(home) @ placed
        if isinstance(primitive, Cylinder) and abs(moved[2, 2]) > 1.0 - _SAME:
            flats.append(Disc(moved[:2, 3], primitive.radius))
            ends.append((moved[2, 3] - primitive.height / 2, moved[2, 3] + primitive.height / 2))
        elif isinstance(primitive, Cube | Prism):
            corners = transform_points(moved, outside(primitive)[0])
            low, high = corners[:, 2].min(), corners[:, 2].max()
            near = _SAME * float(np.ptp(corners, axis=0).max())
            if not (np.minimum(corners[:, 2] - low, high - corners[:, 2]) < near).all():
                return None
            flats.append(Outline(convex_corners(corners[:, :2])))
            ends.append((low, high))
        else:
            return None
    level = np.ptp(np.array(ends), axis=0).max() <= _SAME * np.ptp(np.array(ends))
    return flats if level else None


def _common_profile(leaves: Sequence[tuple[Primitive, Floats]]) -> Floats | None:
    """(n, 2) radii and heights of bars and cones on one axis, in the first one's frame; None if they are not."""
    home = inverse(leaves[0][1])
    profile: list[tuple[float, float]] = []
    for primitive, placed in leaves:
        if not isinstance(primitive, Cylinder | Cone):
            return None
        ends = [primitive.radius] * 2 if isinstance(primitive, Cylinder) else None
        low, high = ends or (primitive.bottom_radius, primitive.top_radius)  # type: ignore[union-attr]
        moved, half = home @ placed, primitive.height / 2
        off = np.abs(moved[:2, 2]).max() + np.abs(moved[:2, 3]).max() / (half + max(low, high))
        if off > _SAME:
            return None
        up = half * np.sign(moved[2, 2])
        for radius, z in ((low, moved[2, 3] - up), (high, moved[2, 3] + up)):
            profile += [(radius, z), (0.0, z)]
    return np.array(profile)


def _moved_sides(corners: Floats, away: float) -> Floats | None:
    """A convex polygon whose sides are moved out; None where one of them vanishes."""
    sides = np.roll(corners, -1, axis=0) - corners
    normals = np.stack([sides[:, 1], -sides[:, 0]], axis=1) / np.linalg.norm(sides, axis=1)[:, None]
    before = np.roll(normals, 1, axis=0)
    bend = 1 + np.einsum("ij,ij->i", normals, before)
    moved: Floats = corners + away * (normals + before) / bend[:, None]
    kept = np.einsum("ij,ij->i", np.roll(moved, -1, axis=0) - moved, sides) > 0
    return moved if kept.all() else None


def _bars(flat: Flat, height: float) -> Csg:
    """A flat hull made solid, its middle at z = 0."""
    match flat:
        case Disc():
            return Cylinder(flat.radius, height).placed(pose(None, (*flat.center, 0.0)))
        case Outline():
            return Prism(tuple(map(tuple, flat.corners.tolist())), height)
    return Union(tuple(_bars(part, height) for part in flat.parts))


def _hull(points: Floats) -> Csg:
    return Polyhedron(tuple(map(tuple, points.tolist())), tuple(map(tuple, convex_faces(points))))


def _leaves(tree: Csg, matrix: Floats) -> list[tuple[Primitive, Floats]]:
    """Placed primitives of a tree that only joins; anything else has no simple hull."""
    match tree:
        case Placed():
            return _leaves(tree.child, matrix @ tree.pose)
        case Union():
            return [leaf for child in tree.children for leaf in _leaves(child, matrix)]
        case Primitive():
            return [(tree, matrix)]
        case Operation():
            raise PalpateError("hull() and minkowski() read primitives and unions; take cuts out of them")
    return []


def _flat_leaves(flat: Flat) -> list[Disc | Outline]:
    if not isinstance(flat, Combined):
        return [flat]
    if flat.operation != "union":
        raise PalpateError("hull() and minkowski() read circles, polygons and unions; take cuts out of them")
    return [leaf for part in flat.parts for leaf in _flat_leaves(part)]
