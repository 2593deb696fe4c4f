"""Flat shapes to an exact tree: rigid motions stay placements, stretches and mirrors go into the sizes.

What no primitive of ours is (an ellipsoid, a sheared cylinder) is refused by name and line.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from models.csg import (
    Cone,
    Csg,
    Cube,
    Cylinder,
    Difference,
    Intersection,
    Polyhedron,
    Prism,
    Sphere,
    Union,
)
from models.formats.openscad import sided, sizes
from models.formats.openscad.affine import TRANSFORMS, matrix_of, split, vector
from models.formats.openscad.convex import hull_of_flats, hull_of_solids, offset, sum_of_flats, sum_of_solids
from models.formats.openscad.extrude import linear, rotated
from models.formats.openscad.flat import Flat, Plan, has_discs
from models.formats.openscad.shapes import Shape
from models.formats.openscad.stretch import flat_sided, stretched
from primitives.arrays import Floats
from primitives.errors import PalpateError
from primitives.pose import pose

_GROUPS = frozenset({"group", "union", "color", "render"})
_MOST_MEANT = 8  # sides up to which $fn is written for the sides: who draws a nut writes $fn = 6
_FEW_SIDES = 13  # circles of fewer sides may be meant as polygons


class Solids:
    """Builds trees; `warnings` says what a reader of the file may not expect."""

    def __init__(self, facets: bool = False) -> None:
        self.facets = facets
        self.warnings: list[str] = []

    def all(self, shapes: Sequence[Shape], scale: float = 1.0) -> Csg | None:
        """The union of what a file draws, each of its units worth `scale` mm."""
        matrix = np.diag([scale, scale, scale, 1.0])
        return _joined(Union, [self.solid(shape, matrix) for shape in shapes])

    def solid(self, shape: Shape, matrix: Floats) -> Csg | None:
        """The solid of one shape under a (4, 4) matrix; None where it is empty."""
        try:
            made = self._made(shape, matrix)
        except PalpateError as error:
            if str(error).startswith(shape.place.split(",")[0]):
                raise
            raise shape.error(str(error)) from None
        except (ArithmeticError, LookupError, ValueError):  # sizes too far apart to compute with
            raise shape.error(f"{shape.name} cannot be made of these numbers; check their sizes") from None
        return made.named(shape.label) if made is not None and shape.label and not _leafy(shape) else made

    def _made(self, shape: Shape, matrix: Floats) -> Csg | None:
        name = shape.name
        if name in _GROUPS:
            return _joined(Union, self._children(shape, matrix))
        if name == "difference":
            return _joined(Difference, self._children(shape, matrix))
        if name == "intersection":
            return _joined(Intersection, self._children(shape, matrix))
        if name in TRANSFORMS:
            return self._moved(shape, matrix @ matrix_of(shape))
        if name in _LEAVES:
            return _LEAVES[name](self, shape, matrix)
        if name in _CONVEX:
            found = [tree for tree in self._children(shape, matrix) if tree is not None]
            return _CONVEX[name](shape, found) if found else None
        if name == "resize":
            return self._resized(shape, matrix)
        if name in ("linear_extrude", "rotate_extrude"):
            return self._extruded(shape, matrix)
        if name in ("circle", "square", "polygon", "offset"):
            raise shape.error(f"{name} is flat where a solid is needed; put it into linear_extrude")
        raise shape.error(f"{name}() is outside the subset that is read; draw the shape with primitives")

    def _children(self, shape: Shape, matrix: Floats) -> list[Csg | None]:
        """What a shape holds; groups that stand for a loop or a call are opened where nothing changes by it."""
        found: list[Csg | None] = []
        for i, child in enumerate(shape.children):
            loose = shape.name not in ("intersection", "minkowski") and not (
                shape.name == "difference" and i == 0
            )
            opened = loose and child.name == "group" and not child.label
            found += self._children(child, matrix) if opened else [self.solid(child, matrix)]
        return found

    def _moved(self, shape: Shape, matrix: Floats) -> Csg | None:
        parts = split(matrix)
        if parts is None:
            return _joined(Union, self._children(shape, matrix))
        rest = np.diag([*parts.stretch, 1.0])
        return _placed(_joined(Union, self._children(shape, rest)), parts.rigid)

    def _resized(self, shape: Shape, matrix: Floats) -> Csg | None:
        tree = _joined(Union, self._children(shape, np.eye(4)))
        if tree is None:
            return None
        low, high = tree.bounds()
        wanted = vector(shape, shape.arguments.get("newsize"), 0.0, "a size")
        if (
            len(list(tree.leaves())) > 1
            or wanted.min() < 0
            or shape.arguments.get("auto", False) not in (False, (0, 0, 0))
        ):
            raise shape.error(
                "resize() reads one primitive and three sizes; use scale() with factors instead"
            )
        factors = np.where(wanted > 0, wanted / (high - low), 1.0)
        return self.refitted(tree, matrix @ np.diag([*factors, 1.0]), shape)

    def _cube(self, shape: Shape, matrix: Floats) -> Csg:
        size = sizes.sides(shape, 3)
        middle = np.zeros(3) if sizes.centered(shape) else size / 2
        return self.fitted(Cube(tuple(size.tolist()), name=shape.label), matrix @ pose(None, middle), shape)

    def _sphere(self, shape: Shape, matrix: Floats) -> Csg:
        radius = sizes.radius(shape)
        made: Csg = Sphere(radius, shape.label)
        if self.sided(shape):
            made = sided.ball(sizes.fragments(shape, radius), radius, shape.label)
        return self.fitted(made, matrix, shape)

    def _cylinder(self, shape: Shape, matrix: Floats) -> Csg:
        height = sizes.length(shape, "h", 1.0)
        low, high = sizes.radius(shape, "1", zero=True), sizes.radius(shape, "2", zero=True)
        if low == high == 0:
            raise shape.error("cylinder's radius must be greater than zero")
        middle = np.array([0.0, 0.0, 0.0 if sizes.centered(shape) else height / 2])
        made: Csg = (
            Cylinder(low, height, shape.label) if low == high else Cone(low, high, height, shape.label)
        )
        if self.sided(shape):
            made = sided.bar(sizes.fragments(shape, max(low, high)), low, high, height, shape.label)
        return self.fitted(made, matrix @ pose(None, middle), shape)

    def _polyhedron(self, shape: Shape, matrix: Floats) -> Csg:
        corners = sizes.points(shape, shape.arguments.get("points"), 3)
        listed = shape.arguments.get("faces", shape.arguments.get("triangles"))
        faces = sizes.indices(shape, listed, len(corners))
        made = Polyhedron(tuple(map(tuple, corners)), tuple(map(tuple, faces)), shape.label)
        return self.fitted(made, matrix, shape)

    def _extruded(self, shape: Shape, matrix: Floats) -> Csg | None:
        plan = Plan(self.sided, _FLAT_CONVEX, offset).union(shape.children)
        if plan is None:
            return None
        made = linear(shape, plan) if shape.name == "linear_extrude" else self._rotated(shape, plan)
        tree = self.refitted(made, matrix, shape)
        return tree.named(shape.label) if shape.label else tree

    def _rotated(self, shape: Shape, plan: Flat) -> Csg:
        """Of a few sides, where it is a whole turn of what has corners; a ring of a circle is round."""
        if abs(sizes.number(shape, "angle", 360.0)) >= 360.0 and not has_discs(plan):
            return rotated(shape, plan, self.sided(shape))
        if not self.facets and 0 < shape.facets[0] < _FEW_SIDES:
            self._say_round(shape)
        return rotated(shape, plan, self.facets)

    def sided(self, shape: Shape) -> bool:
        """Whether a circle keeps its sides; warns where it does not and they may be meant."""
        if self.facets or 0 < shape.facets[0] <= _MOST_MEANT:
            return True
        if 0 < shape.facets[0] < _FEW_SIDES:
            self._say_round(shape)
        return False

    def _say_round(self, shape: Shape) -> None:
        few = f"{shape.place}: {shape.name} with $fn = {shape.facets[0]:g} is read as round; "
        self.warnings.append(few + "--facets keeps its sides, and those of all circles")

    def refitted(self, tree: Csg, matrix: Floats, shape: Shape) -> Csg:
        """A tree that is not of one primitive under a matrix."""
        parts = split(matrix)
        if parts is not None and np.array_equal(parts.stretch, np.ones(3)):
            placed = _placed(tree, parts.rigid)
            assert placed is not None
            return placed
        children = getattr(tree, "children", None)
        if children:
            return type(tree)(tuple(self.refitted(c, matrix, shape) for c in children))  # type: ignore[call-arg]
        child, moved = getattr(tree, "child", tree), getattr(tree, "pose", np.eye(4))
        if child is not tree and not hasattr(child, "support"):
            return self.refitted(child, matrix @ moved, shape)
        return self.fitted(child, matrix @ moved, shape)

    def fitted(self, primitive: Csg, matrix: Floats, shape: Shape) -> Csg:
        """A primitive under a matrix, its sizes stretched."""
        parts = split(matrix)
        if parts is not None and np.array_equal(parts.stretch, np.ones(3)):
            made: Csg | None = primitive
        elif isinstance(primitive, Cube | Prism | Polyhedron):
            return flat_sided(primitive, matrix, parts)
        elif parts is None:
            raise shape.error(f"a sheared or slanting {shape.name} has no exact form here; stretch it evenly")
        else:
            made = stretched(primitive, np.abs(parts.stretch), parts.stretch[2] < 0)
        if made is None or parts is None:
            raise shape.error(
                f"{shape.name} is stretched to an ellipse, which has no exact form here; scale it evenly"
            )
        placed = _placed(made, parts.rigid)
        assert placed is not None
        return placed


def _placed(tree: Csg | None, rigid: Floats) -> Csg | None:
    return tree if tree is None or np.array_equal(rigid, np.eye(4)) else tree.placed(rigid)


def _joined(operation: type[Union | Difference | Intersection], found: Sequence[Csg | None]) -> Csg | None:
    """The operation on what is not empty; empty where that is the result."""
    solids = [tree for tree in found if tree is not None]
    if operation is Intersection and len(solids) < len(found):
        return None
    if not solids or (operation is Difference and found[0] is None):
        return None
    return solids[0] if len(solids) == 1 else operation(tuple(solids))


def _leafy(shape: Shape) -> bool:
    return shape.name in _LEAVES or shape.name.endswith("_extrude")


_CONVEX = {"hull": hull_of_solids, "minkowski": sum_of_solids}
_FLAT_CONVEX = {"hull": hull_of_flats, "minkowski": sum_of_flats}
_LEAVES: dict[str, Callable[[Solids, Shape, Floats], Csg]] = {
    "cube": Solids._cube,
    "sphere": Solids._sphere,
    "cylinder": Solids._cylinder,
    "polyhedron": Solids._polyhedron,
}
