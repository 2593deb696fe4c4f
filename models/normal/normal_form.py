"""The normal form of a tree, and whether two trees are the same.

Placements go down to the leaves, unions and intersections of the same kind become one, what is taken away is
taken away one by one, repeated and commutative children stand in a fixed order, names are dropped, and leaves
are written one way (`normal_leaf`).  Two solids with one normal form are equal; equal solids may be built from
different primitives, which only their boundaries tell.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from models.csg import (
    Cone,
    Csg,
    Cube,
    Cylinder,
    Difference,
    Intersection,
    Operation,
    Placed,
    Polyhedron,
    Primitive,
    Prism,
    Sphere,
    Torus,
    Union,
)
from models.normal.normal_leaf import DIGITS, normal_leaf
from primitives.arrays import Bools, Floats, Ints
from primitives.pose import pose, transform_points

TOLERANCE = 1e-6  # [mm] between points of trees that are the same


def normal_form(tree: Csg) -> Csg:
    """The tree that stands for all ways to write the same expression; rounded, so that `==` compares."""
    return _spread(tree, np.eye(4))


def same_tree(a: Csg, b: Csg, tolerance: float = TOLERANCE) -> bool:
    """Whether two trees are one expression but for names and for `tolerance` [mm] in where primitives end."""
    return _same(normal_form(a), normal_form(b), tolerance)


def _spread(tree: Csg, part_from_tree: Floats) -> Csg:
    match tree:
        case Placed():
            return _spread(tree.child, part_from_tree @ tree.pose)
        case Difference():
            first, *rest = [_spread(child, part_from_tree) for child in tree.children]
            taken = [part for child in rest for part in _parts(child, Union)]
            if isinstance(first, Difference):
                taken = [*first.children[1:], *taken]
            return Difference((_parts(first, Difference)[0], *_ordered(taken)))
        case Operation():
            kind = Union if isinstance(tree, Union) else Intersection
            children = [_spread(child, part_from_tree) for child in tree.children]
            parts = _ordered([part for child in children for part in _parts(child, kind)])
            return parts[0] if len(parts) == 1 else kind(tuple(parts))
        case Primitive():
            primitive, placed = normal_leaf(tree, part_from_tree)
            turn, shift = np.round(placed[:3, :3], DIGITS + 1) + 0.0, np.round(placed[:3, 3], DIGITS) + 0.0
            still = not shift.any() and np.array_equal(turn, np.eye(3))
            return _trimmed(primitive) if still else _trimmed(primitive).placed(pose(turn, shift))
    return tree


def _parts(tree: Csg, kind: type[Operation]) -> Sequence[Csg]:
    return tree.children if isinstance(tree, kind) else (tree,)


def _ordered(trees: Sequence[Csg]) -> list[Csg]:
    return sorted(
        dict.fromkeys(trees), key=lambda tree: (type(next(tree.leaves()).primitive).__name__, repr(tree))
    )


def _trimmed(primitive: Primitive) -> Primitive:
    """With sizes rounded."""

    def short(value: float) -> float:
        return round(value, DIGITS) + 0.0

    match primitive:
        case Cube():
            x, y, z = map(short, primitive.size)
            return Cube((x, y, z))
        case Cylinder():
            return Cylinder(short(primitive.radius), short(primitive.height))
        case Cone():
            return Cone(short(primitive.bottom_radius), short(primitive.top_radius), short(primitive.height))
        case Sphere():
            return Sphere(short(primitive.radius))
        case Torus():
            return Torus(short(primitive.major_radius), short(primitive.minor_radius))
        case Prism():
            return Prism(tuple((short(x), short(y)) for x, y in primitive.outline), short(primitive.height))
    return primitive


def _same(a: Csg, b: Csg, tolerance: float) -> bool:
    if isinstance(a, Operation) or isinstance(b, Operation):
        if isinstance(a, Operation) and isinstance(b, Operation) and type(a) is type(b):
            return _same_children(a, b, tolerance)
        return False
    first, second = next(a.leaves()), next(b.leaves())
    if type(first.primitive) is not type(second.primitive):
        return False
    one, other = _features(*first[:2]), _features(*second[:2])
    return all(_same_points(p, q, tolerance) for p, q in zip(one, other, strict=True)) and _same_faces(
        *first[:2], *second[:2], tolerance
    )


def _same_children(a: Operation, b: Operation, tolerance: float) -> bool:
    """Whether each operand of one is found in the other: repeating or reordering one changes nothing."""
    fixed = isinstance(a, Difference)
    if fixed and not _same(a.children[0], b.children[0], tolerance):
        return False
    ours, theirs = a.children[fixed:], b.children[fixed:]
    if len(ours) == len(theirs) and all(_same(x, y, tolerance) for x, y in zip(ours, theirs, strict=True)):
        return True
    fits: Bools = np.array([[_same(x, y, tolerance) for y in theirs] for x in ours])
    return bool(fits.any(axis=0).all() and fits.any(axis=1).all())


def _features(primitive: Primitive, placed: Floats) -> list[Floats]:
    """Sets of points that tell a placed primitive from others of its kind; the order within a set is free."""
    center, z = placed[:3, 3], placed[:3, 2]
    match primitive:
        case Sphere():
            return [center[None], np.array([[primitive.radius]])]
        case Cylinder():
            ends = center + np.outer([-0.5, 0.5], z) * primitive.height
            return [ends, np.array([[primitive.radius]])]
        case Cone():
            low, high = center + np.outer([-0.5, 0.5], z) * primitive.height
            return [
                np.array([[*low, primitive.bottom_radius], [*high, primitive.top_radius]]),
            ]
        case Torus():
            ends = center + np.outer([-1.0, 1.0], z) * primitive.major_radius
            return [ends, np.array([[primitive.major_radius], [primitive.minor_radius]])]
        case Cube():
            corners = np.array(np.meshgrid(*[[-s / 2, s / 2] for s in primitive.size])).reshape(3, -1).T
            return [transform_points(placed, corners)]
    return [_corners(primitive, placed)]


def _corners(primitive: Primitive, placed: Floats) -> Floats:
    if isinstance(primitive, Polyhedron):
        return transform_points(placed, np.array(primitive.points))
    assert isinstance(primitive, Prism)
    ends = [(x, y, z) for z in (-primitive.height / 2, primitive.height / 2) for x, y in primitive.outline]
    return transform_points(placed, np.array(ends))


def _same_points(a: Floats, b: Floats, tolerance: float) -> bool:
    if a.shape != b.shape:
        return False
    away, which = _nearest(a, b)
    return bool(away.max() <= tolerance and len(np.unique(which)) == len(b))


def _nearest(a: Floats, b: Floats) -> tuple[Floats, Ints]:
    """Distance to and index of the point of b nearest to each of a."""
    away, which = cKDTree(b).query(a)
    return np.asarray(away), np.asarray(which, dtype=np.int64)


def _same_faces(a: Primitive, a_pose: Floats, b: Primitive, b_pose: Floats, tolerance: float) -> bool:
    """Whether corners that agree also bound the same faces; only prisms and polyhedra can differ there."""
    if not isinstance(a, Prism | Polyhedron):
        return True
    _, which = _nearest(_corners(a, a_pose), _corners(b, b_pose))
    ours = {frozenset(int(which[i]) for i in face) for face in _rings(a)}
    return ours == {frozenset(face) for face in _rings(b)}


def _rings(primitive: Primitive) -> Sequence[Sequence[int]]:
    if isinstance(primitive, Polyhedron):
        return primitive.faces
    assert isinstance(primitive, Prism)
    n = len(primitive.outline)
    return [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)]
