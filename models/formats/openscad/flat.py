"""Flat shapes: discs, polygons and booleans of them, placed in the plane."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from models.formats.openscad import sizes
from models.formats.openscad.affine import SIX_DIGITS, TRANSFORMS, matrix_of
from models.formats.openscad.shapes import Shape
from models.formats.openscad.sided import polygon
from models.leaves.polygons import polygon_distance
from primitives.arrays import Floats
from primitives.outlines import signed_area

_GROUPS = frozenset({"group", "union", "color", "render"})


@dataclass(frozen=True, eq=False)
class Disc:
    """A circle's inside."""

    center: Floats  # (2,) [mm]
    radius: float  # [mm]
    label: str = ""


@dataclass(frozen=True, eq=False)
class Outline:
    """A simple polygon's inside, its corners counterclockwise."""

    corners: Floats  # (n, 2) [mm]
    label: str = ""


@dataclass(frozen=True)
class Combined:
    """Flat shapes under `union`, `difference` or `intersection`."""

    operation: str
    parts: tuple[Flat, ...]


Flat = Disc | Outline | Combined


class Plan:
    """Reads the children of an extrusion."""

    def __init__(
        self,
        sided: Callable[[Shape], bool],
        convex: Mapping[str, Callable[[Shape, Sequence[Flat]], Flat]],
        offset: Callable[[Shape, Flat], Flat],
    ) -> None:
        self._sided = sided
        self._convex = convex
        self._offset = offset

    def union(self, shapes: Sequence[Shape], matrix: Floats | None = None) -> Flat | None:
        """What the shapes cover together, under a (4, 4) matrix."""
        return _joined(
            "union", [self._flat(shape, np.eye(4) if matrix is None else matrix) for shape in shapes]
        )

    def _flat(self, shape: Shape, matrix: Floats) -> Flat | None:
        name = shape.name
        if name in _GROUPS:
            return self.union(shape.children, matrix)
        if name in ("difference", "intersection"):
            return _joined(name, [self._flat(child, matrix) for child in shape.children])
        if name in TRANSFORMS:
            return self.union(shape.children, matrix @ _in_plane(shape))
        if name in ("hull", "minkowski"):
            found = [flat for child in shape.children if (flat := self._flat(child, matrix)) is not None]
            return self._convex[name](shape, found) if found else None
        if name == "offset":
            flat = self.union(shape.children)
            return None if flat is None else transformed(self._offset(shape, flat), matrix, shape)
        if name == "circle":
            return self._circle(shape, matrix)
        if name == "square":
            size = sizes.sides(shape, 2)
            corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * size - sizes.centered(shape) * size / 2
            return _outline(corners, matrix, shape.label)
        if name == "polygon":
            return _polygon(shape, matrix)
        if name in ("cube", "sphere", "cylinder", "polyhedron", "linear_extrude", "rotate_extrude"):
            raise shape.error(f"{name} is solid where a flat shape is needed; use circle, square or polygon")
        raise shape.error(f"{name}() is outside the subset that is read; draw the outline as a polygon")

    def _circle(self, shape: Shape, matrix: Floats) -> Flat:
        radius = sizes.radius(shape)
        if self._sided(shape):
            return _outline(polygon(sizes.fragments(shape, radius), radius), matrix, shape.label)
        return transformed(Disc(np.zeros(2), radius, shape.label), matrix, shape)


def transformed(flat: Flat, matrix: Floats, shape: Shape) -> Flat:
    """A flat shape under a (4, 4) matrix that keeps it in the plane."""
    linear = matrix[:2, :2]
    match flat:
        case Outline():
            return _outline(flat.corners, matrix, flat.label)
        case Combined():
            return Combined(flat.operation, tuple(transformed(part, matrix, shape) for part in flat.parts))
    factor = float(np.sqrt(abs(np.linalg.det(linear))))
    if np.abs(linear.T @ linear / factor**2 - np.eye(2)).max() > SIX_DIGITS:
        raise shape.error(
            f"{shape.name} is stretched to an ellipse, which has no exact form here; scale it evenly"
        )
    near = float(f"{factor:.5g}")
    factor = near if abs(factor - near) <= SIX_DIGITS * near else factor
    return Disc(linear @ flat.center + matrix[:2, 3], flat.radius * factor, flat.label)


def bounds(flat: Flat) -> Floats:
    """(2, 2) least and greatest corner of a box that holds the shape [mm]."""
    match flat:
        case Disc():
            return np.stack([flat.center - flat.radius, flat.center + flat.radius])
        case Outline():
            return np.stack([flat.corners.min(axis=0), flat.corners.max(axis=0)])
    boxes = np.stack([bounds(part) for part in flat.parts])
    if flat.operation == "difference":
        return np.asarray(boxes[0])
    if flat.operation == "union":
        return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])
    return np.stack([boxes[:, 0].max(axis=0), boxes[:, 1].min(axis=0)])


def _in_plane(shape: Shape) -> Floats:
    matrix = matrix_of(shape)
    if np.abs(matrix[:2, 2]).max() > SIX_DIGITS or np.abs(matrix[2, :2]).max() > SIX_DIGITS:
        raise shape.error(
            f"{shape.name} turns a flat shape out of its plane; turn the extruded solid instead"
        )
    return matrix


def _polygon(shape: Shape, matrix: Floats) -> Flat:
    corners = sizes.points(shape, shape.arguments.get("points"), 2)
    listed = shape.arguments.get("paths")
    if listed is None:
        return _outline(corners, matrix, shape.label)
    rings = [corners[ring] for ring in sizes.indices(shape, listed, len(corners))]
    rings.sort(key=lambda ring: -abs(signed_area(ring)))
    outer, *holes = [_outline(ring, matrix, shape.label if i == 0 else "") for i, ring in enumerate(rings)]
    for i, hole in enumerate(holes):
        inside = polygon_distance(hole.corners, outer.corners).max() < 0
        apart = all(polygon_distance(hole.corners, other.corners).min() > 0 for other in holes[:i])
        if not (inside and apart):
            raise shape.error("polygon's paths must be one outline and holes within it; draw the rest apart")
    return _joined("difference", [outer, *holes]) or outer


def _outline(corners: Floats, matrix: Floats, label: str) -> Outline:
    moved = corners @ matrix[:2, :2].T + matrix[:2, 3]
    return Outline(moved if signed_area(moved) > 0 else moved[::-1], label)


def _joined(operation: str, found: Sequence[Flat | None]) -> Flat | None:
    flats = [flat for flat in found if flat is not None]
    if operation == "intersection" and len(flats) < len(found):
        return None
    if not flats or (operation == "difference" and found[0] is None):
        return None
    return flats[0] if len(flats) == 1 else Combined(operation, tuple(flats))


def has_discs(flat: Flat) -> bool:
    """Whether a circle is part of it."""
    return any(map(has_discs, flat.parts)) if isinstance(flat, Combined) else isinstance(flat, Disc)
