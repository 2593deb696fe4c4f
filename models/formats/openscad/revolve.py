"""A disc or polygon turned about the y axis of its plane, which becomes z: tori, balls, cylinders and cones.

A polygon is cut at the heights of its corners.  Where every level meets it once, its right side turns to cones
and cylinders in a stack and its left side to those that are taken out; elsewhere each piece is a ring by itself.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from models.csg import Cone, Csg, Cylinder, Difference, Sphere, Torus, Union
from models.formats.openscad.flat import Disc, Outline
from models.formats.openscad.shapes import Shape
from models.leaves.polygons import cleaned
from primitives.arrays import Floats
from primitives.errors import PalpateError

Side = tuple[Floats, Floats]  # lower and upper end (radius, height) [mm]
_TOUCH = 1e-9  # of the profile's size: nearer than this to the axis is on it
_OVERREACH = 0.5  # of a bore's length, that a cutter stands out at an open end


def turned_ring(shape: Shape, disc: Disc) -> Csg:
    """A disc turned: a torus, or a ball where its center is on the axis."""
    x, y = disc.center.tolist()
    if abs(x) <= _TOUCH * disc.radius:
        return _at(Sphere(disc.radius, disc.label), y)
    if x <= disc.radius:
        raise shape.error("rotate_extrude's circle reaches the axis; move it out, or draw a sphere")
    return _at(Torus(x, disc.radius, disc.label), y)


def turned_outline(outline: Outline) -> Csg:
    """A polygon's part with x >= 0 turned."""
    corners = _leveled(right_half(cleaned(outline.corners)))
    if len(corners) < 3:
        raise PalpateError("an outline needs three corners or more that are not on one line")
    levels = np.unique(corners[:, 1])
    rows = [_crossings(corners, low, high) for low, high in pairwise(levels)]
    if all(len(row) == 2 for row in rows):
        outer, inner = (_merged([row[k] for row in rows]) for k in (1, 0))
        tree = _stack(outer, outline.label)
        bores = [_frustum(side, *_open_ends(inner, i)) for i, side in enumerate(inner) if _round(side)]
        return Difference((tree, *bores)) if bores else tree
    rings = []
    for row in rows:
        for left, right in zip(row[::2], row[1::2], strict=True):
            ring: Csg = _frustum(right)
            rings.append(ring - _frustum(left) if _round(left) else ring)
    made: Csg = Union(tuple(rings))
    return made.named(outline.label) if outline.label else made


def _leveled(corners: Floats) -> Floats:
    """With heights that only rounding keeps apart made one: between them is no cone, but nothing."""
    if not len(corners):
        return corners
    heights, row = np.unique(corners[:, 1], return_inverse=True)
    apart = np.diff(heights, prepend=heights[0]) > _TOUCH * max(float(np.abs(corners).max()), 1e-300)
    first = np.maximum.accumulate(np.where(apart, np.arange(len(heights)), 0))
    return np.column_stack([corners[:, 0], heights[first][row]])


def _crossings(corners: Floats, low: float, high: float) -> list[Side]:
    """The sides between two levels, cut to them, from left to right."""
    found: list[Side] = []
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        below, above = (a, b) if a[1] < b[1] else (b, a)
        if below[1] <= low and above[1] >= high and above[1] > below[1]:
            ends = []
            for level in (low, high):
                share = (level - below[1]) / (above[1] - below[1])
                ends.append(np.array([below[0] + share * (above[0] - below[0]), level]))
            found.append((ends[0], ends[1]))
    return sorted(found, key=lambda side: float(side[0][0] + side[1][0]))


def _merged(sides: list[Side]) -> list[Side]:
    """Sides that go on in a straight line made one."""
    out = [sides[0]]
    for low, high in sides[1:]:
        start, end = out[-1]
        first, second = end - start, high - low
        joined = np.abs(end - low).max() <= _TOUCH * max(abs(high).max(), 1e-300)
        if joined and abs(first[0] * second[1] - first[1] * second[0]) <= _TOUCH * first[1] * second[1]:
            out[-1] = (start, high)
        else:
            out.append((low, high))
    return out


def _stack(sides: list[Side], label: str) -> Csg:
    pieces = [_frustum(side) for side in sides if _round(side)]
    tree = pieces[0] if len(pieces) == 1 else Union(tuple(pieces))
    return tree.named(label) if label else tree


def _round(side: Side) -> bool:
    """Whether anything is left of it when turned."""
    (a, low), (b, high) = side
    return bool(max(a, b) > _TOUCH * max(abs(low), abs(high), high - low))


def _open_ends(sides: list[Side], place: int) -> tuple[bool, bool]:
    """Whether a straight bore may stand out below and above."""
    return place == 0, place == len(sides) - 1


def _frustum(side: Side, longer_below: bool = False, longer_above: bool = False) -> Csg:
    (a, low), (b, high) = ((float(r), float(z)) for r, z in side)
    a, b = (0.0 if r <= _TOUCH * (high - low) else r for r in (a, b))
    if abs(a - b) > _TOUCH * max(a, b):
        return _at(Cone(a, b, high - low), (low + high) / 2)
    more = _OVERREACH * (high - low)
    low, high = low - more * longer_below, high + more * longer_above
    return _at(Cylinder(a, high - low), (low + high) / 2)


def right_half(corners: Floats) -> Floats:
    """The polygon cut at x = 0 (Sutherland and Hodgman 1974)."""
    if corners[:, 0].min() >= 0:
        return corners
    out = []
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if a[0] >= 0:
            out.append(a)
        if (a[0] < 0) != (b[0] < 0):
            out.append(np.array([0.0, a[1] - a[0] * (b[1] - a[1]) / (b[0] - a[0])]))
    return np.array(out)


def _at(tree: Csg, z: float) -> Csg:
    return tree.at(0, 0, z) if z else tree
