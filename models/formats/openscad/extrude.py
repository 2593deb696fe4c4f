"""Flat shapes to solids: pulled along z, or turned about it.

Both commute with union, difference and intersection, so every disc and polygon becomes primitives by itself.
What is taken away is made taller than what it is taken from, so that no two ends lie in one plane; what it
takes away within its neighbor stays the same (our derivation).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from models.csg import Cone, Csg, Cube, Cylinder, Difference, Intersection, Polyhedron, Prism, Union
from models.formats.openscad import sizes
from models.formats.openscad.flat import Combined, Disc, Flat, Outline, bounds
from models.formats.openscad.revolve import right_half, turned_outline, turned_ring
from models.formats.openscad.shapes import Shape
from models.formats.openscad.sided import turned
from models.formats.openscad.values import Value, is_number
from models.leaves.polygons import cleaned
from primitives.arrays import Floats
from primitives.pose import pose

_OPERATIONS: dict[str, Callable[[tuple[Csg, ...]], Csg]] = {
    "union": Union,
    "difference": Difference,
    "intersection": Intersection,
}
_OVERREACH = 0.5  # of the height, that a cutter stands out at each end
_SQUARE = 1e-9  # [1] cosine of a corner that is taken to be right


def linear(shape: Shape, flat: Flat) -> Csg:
    """`linear_extrude`."""
    height = sizes.length(shape, "height", 100.0)
    if sizes.number(shape, "twist", 0.0) != 0:
        raise shape.error("linear_extrude with twist has no exact form here; leave twist out")
    scale = _scale(shape, shape.arguments.get("scale"))
    low = -height / 2 if sizes.centered(shape) else 0.0
    if not np.array_equal(scale, [1, 1]):
        return _each(flat, lambda leaf, level: _tapered(shape, leaf, height, scale), 0).at(
            0, 0, low + height / 2
        )

    def prism(leaf: Disc | Outline, level: int) -> Csg:
        return _straight(leaf, height * (1 + 2 * _OVERREACH * level), low + height / 2)

    return _each(flat, prism, 0)


def rotated(shape: Shape, flat: Flat, facets: bool = False) -> Csg:
    """`rotate_extrude`; with `facets` it has OpenSCAD's flat sides."""
    angle = sizes.number(shape, "angle", 360.0)
    angle = 360.0 if abs(angle) > 360 else angle
    if angle == 0:
        raise shape.error("rotate_extrude's angle must not be zero")
    low, high = bounds(flat)
    rim = 1e-9 * max(abs(low[0]), abs(high[0]))
    left = high[0] <= rim
    if left:
        flat, low, high = _mirrored(flat), np.array([-high[0], low[1]]), np.array([-low[0], high[1]])
    if low[0] < -rim and not isinstance(flat, Combined):
        raise shape.error("rotate_extrude's shape lies on both sides of the axis; move it to one")

    def ring(leaf: Disc | Outline, level: int) -> Csg:
        if facets and isinstance(leaf, Outline):
            return turned(right_half(leaf.corners), fragments, leaf.label)
        return turned_ring(shape, leaf) if isinstance(leaf, Disc) else turned_outline(leaf)

    fragments = sizes.fragments(shape, float(high[0]))
    if facets and abs(angle) != 360:
        raise shape.error(
            "rotate_extrude by less than a full turn is read round only; read it without facets"
        )
    whole = _each(flat, ring, 0)
    if abs(angle) == 360:  # OpenSCAD begins it on the -x axis
        return whole.turned("z", np.pi) if facets and fragments % 2 else whole
    start = (180.0 if left else 0.0) + min(angle, 0.0)
    return _sector(whole, start, abs(angle), float(high[0]), low[1], high[1])


def _each(flat: Flat, solid: Callable[[Disc | Outline, int], Csg], level: int) -> Csg:
    """Every leaf made solid; `level` counts how often it is taken away from something."""
    if not isinstance(flat, Combined):
        return solid(flat, level)
    cut = flat.operation == "difference"
    parts = tuple(_each(part, solid, level + (cut and i > 0)) for i, part in enumerate(flat.parts))
    return _OPERATIONS[flat.operation](parts)


def _straight(leaf: Disc | Outline, height: float, middle: float) -> Csg:
    if isinstance(leaf, Disc):
        return _at(Cylinder(leaf.radius, height, leaf.label), np.array([*leaf.center, middle]))
    corners = cleaned(leaf.corners)
    if len(corners) == 4:
        along, across = corners[1] - corners[0], corners[3] - corners[0]
        x, y = float(np.linalg.norm(along)), float(np.linalg.norm(across))
        opposite = np.abs(corners[0] + corners[2] - corners[1] - corners[3]).max()
        if opposite <= _SQUARE * (x + y) and abs(along @ across) <= _SQUARE * x * y:
            turn = np.array([[along[0], -along[1], 0], [along[1], along[0], 0], [0, 0, x]]) / x
            center = np.array([*corners.mean(axis=0), middle])
            quarter = np.abs(np.abs(turn[:2, :2]) - np.eye(2)[::-1]).max() < 1e-12
            if quarter:
                return _at(Cube((y, x, height), leaf.label), center)
            turned = np.abs(np.abs(turn) - np.eye(3)).max() >= 1e-12
            cube = Cube((x, y, height), leaf.label)
            return cube.placed(pose(turn, center)) if turned else _at(cube, center)
    return _at(Prism(tuple(map(tuple, corners.tolist())), height, leaf.label), np.array([0.0, 0.0, middle]))


def _tapered(shape: Shape, leaf: Disc | Outline, height: float, scale: Floats) -> Csg:
    """A leaf that shrinks or grows toward its top, its middle at z = 0."""
    if isinstance(leaf, Disc):
        if np.abs(leaf.center).max() > 1e-9 * leaf.radius or scale[0] != scale[1]:
            raise shape.error(
                "linear_extrude tapers a circle to a slanting cone; center it and scale it evenly"
            )
        return Cone(leaf.radius, leaf.radius * float(scale[0]), height, leaf.label)
    base = cleaned(leaf.corners)
    n = len(base)
    low = np.column_stack([base, np.full(n, -height / 2)])
    top = (
        np.array([[0.0, 0.0, height / 2]])
        if not scale.any()
        else np.column_stack([base * scale, low[:, 2] + height])
    )
    around = [(i, (i + 1) % n, *((n + (i + 1) % n, n + i) if len(top) > 1 else (n,))) for i in range(n)]
    ends = [tuple(range(n))[::-1], *([tuple(range(n, 2 * n))] if len(top) > 1 else [])]
    corners = tuple(map(tuple, np.concatenate([low, top]).tolist()))
    return Polyhedron(corners, (*ends, *around), leaf.label)


def _scale(shape: Shape, value: Value) -> Floats:
    if value is None:
        return np.ones(2)
    pair = (value, value) if is_number(value) else value
    if (
        not isinstance(pair, tuple)
        or len(pair) < 2
        or not all(is_number(s) and 0 <= s < np.inf for s in pair[:2])
    ):
        raise shape.error("linear_extrude's scale must be a number or two, not less than zero")
    if min(pair[:2]) == 0 < max(pair[:2]):
        raise shape.error("linear_extrude tapers to a line; scale to zero in both directions or in none")
    return np.array(pair[:2])


def _sector(whole: Csg, start: float, angle: float, reach: float, low: float, high: float) -> Csg:
    """The part of a turned solid from `start` on [deg]."""
    if angle > 180:
        return whole - _wedge(start + angle, 360 - angle, reach, low, high)
    return whole & _wedge(start, angle, reach, low, high)


def _wedge(start: float, angle: float, reach: float, low: float, high: float) -> Csg:
    steps = np.radians(np.linspace(start, start + angle, int(np.ceil(angle / 60)) + 1))
    rim = 1.5 * reach * np.stack([np.cos(steps), np.sin(steps)], axis=1)
    corners = np.asarray(np.round(np.vstack([np.zeros(2), rim]), 12), dtype=np.float64)
    return _straight(Outline(corners), 2 * (high - low), (low + high) / 2)


def _mirrored(flat: Flat) -> Flat:
    match flat:
        case Disc():
            return Disc(flat.center * [-1, 1], flat.radius, flat.label)
        case Outline():
            return Outline((flat.corners * [-1, 1])[::-1], flat.label)
    return Combined(flat.operation, tuple(map(_mirrored, flat.parts)))


def _at(tree: Csg, center: Floats) -> Csg:
    return tree.at(*center.tolist()) if center.any() else tree
