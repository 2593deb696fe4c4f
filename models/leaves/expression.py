"""Solids as expressions: union, intersection, difference and placement of what `models.csg` defines.

A tree is frozen, compares and hashes by structure, and its ``repr`` is the Python that builds it again.

`signed_distance` is exact for a primitive.  Under `|` it is the least and under `&` and `-` the greatest of
the children's, which has the right sign everywhere and never exceeds the true distance in size (Hart 1996,
section 3.4): a sound clearance, not the distance.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, field, fields, replace
from functools import reduce
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from primitives.arrays import Floats, frozen
from primitives.errors import PalpateError
from primitives.pose import inverse, pose, rotation_exp, rotation_log, transform_points

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_REPR_DIGITS = (4, 13, 15, 17)  # of axes and angles, the shortest that gives the same pose back
_SIX = frozen(np.concatenate([np.eye(3), -np.eye(3)]))


class Leaf(NamedTuple):
    """One primitive of a tree."""

    primitive: Primitive
    part_from_primitive: Floats  # (4, 4)
    adds: bool  # whether it adds material; false under an odd number of subtractions


class Csg(ABC):
    """A solid as an expression; see the module for what it may be made of."""

    name: str

    def __or__(self, other: Csg) -> Union:
        return Union((self, other))

    def __and__(self, other: Csg) -> Intersection:
        return Intersection((self, other))

    def __sub__(self, other: Csg) -> Difference:
        return Difference((self, other))

    def placed(self, parent_from_child: ArrayLike) -> Placed:
        """The solid moved by a (4, 4) pose."""
        return Placed(self, np.asarray(parent_from_child, dtype=float))

    def at(self, x: float, y: float, z: float) -> Placed:
        """The solid moved by (x, y, z) [mm]."""
        return self.placed(pose(None, (x, y, z)))

    def turned(self, axis: str | ArrayLike, angle: float) -> Placed:
        """The solid turned about a line through the origin: `axis` is x, y, z or a direction; [rad]."""
        direction = np.asarray(_AXES[axis] if isinstance(axis, str) else axis, dtype=float)
        turn = np.round(rotation_exp(direction / np.linalg.norm(direction) * angle), 12)
        return self.placed(pose(turn))

    def named(self, name: str) -> Self:
        """The same solid under a name that files show."""
        return replace(self, name=name)  # type: ignore[type-var]

    @abstractmethod
    def scaled(self, factor: float) -> Csg:
        """The solid with every length times a positive factor, about its origin."""

    @abstractmethod
    def leaves(self, part_from_self: Floats | None = None, adds: bool = True) -> Iterator[Leaf]:
        """Every primitive, left to right, with its pose in the part frame."""

    def bounds(self) -> Floats:
        """(2, 3) least and greatest corner of a box that holds the solid [mm]; tight for one primitive."""
        return self._bounds(np.eye(4))

    @abstractmethod
    def signed_distance(self, points: Floats) -> Floats:
        """(n,) distance of (n, 3) points [mm], negative inside: exact for primitives, else a bound."""

    @abstractmethod
    def _bounds(self, part_from_self: Floats) -> Floats:
        """Of the solid in the part frame."""


class Primitive(Csg):
    """A leaf of the tree."""

    @abstractmethod
    def support(self, directions: Floats) -> Floats:
        """(n,) the farthest that the solid reaches along each of (n, 3) unit directions [mm]."""

    def scaled(self, factor: float) -> Self:
        """Every field but the name is a length or holds lengths, unless a primitive says otherwise."""
        lengths = [f.name for f in fields(self) if f.name != "name"]  # type: ignore[arg-type]
        return replace(self, **{key: times(getattr(self, key), factor) for key in lengths})  # type: ignore[type-var]

    def leaves(self, part_from_self: Floats | None = None, adds: bool = True) -> Iterator[Leaf]:
        """Itself."""
        yield Leaf(self, frozen(np.eye(4) if part_from_self is None else part_from_self), adds)

    def _bounds(self, part_from_self: Floats) -> Floats:
        reach = self.support(_SIX @ part_from_self[:3, :3]) + _SIX @ part_from_self[:3, 3]
        return np.stack([-reach[3:], reach[:3]])

    def _label(self) -> str:
        return f", name={self.name!r})" if self.name else ")"


@dataclass(frozen=True, repr=False, eq=False)
class Placed(Csg):
    """A solid in another place; placing what is placed composes the two."""

    child: Csg
    pose: Floats  # (4, 4) parent_from_child
    name: str = field(default="")

    def __post_init__(self) -> None:
        moved = np.asarray(self.pose, dtype=float) + 0.0
        rigid = moved.shape == (4, 4) and np.allclose(moved[:3, :3] @ moved[:3, :3].T, np.eye(3), atol=1e-9)
        if not rigid or not np.isfinite(moved).all() or np.linalg.det(moved[:3, :3]) < 0:
            raise PalpateError("a placement must be a (4, 4) rigid motion, without scale or mirror")
        if isinstance(self.child, Placed) and not self.child.name:
            moved = _compose(moved, self.child.pose)
            object.__setattr__(self, "child", self.child.child)
        object.__setattr__(self, "pose", frozen(moved))

    def scaled(self, factor: float) -> Placed:
        """The child's, its place scaled too."""
        return Placed(
            self.child.scaled(factor), pose(self.pose[:3, :3], factor * self.pose[:3, 3]), self.name
        )

    def leaves(self, part_from_self: Floats | None = None, adds: bool = True) -> Iterator[Leaf]:
        """The child's, moved."""
        moved = self.pose if part_from_self is None else part_from_self @ self.pose
        return self.child.leaves(moved, adds)

    def signed_distance(self, points: Floats) -> Floats:
        """The child's, in its own frame."""
        return self.child.signed_distance(transform_points(inverse(self.pose), points))

    def _bounds(self, part_from_self: Floats) -> Floats:
        return self.child._bounds(part_from_self @ self.pose)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Placed) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())

    def __repr__(self) -> str:
        label = f".named({self.name!r})" if self.name else ""
        turn, shift = self.pose[:3, :3], self.pose[:3, 3]
        at = f".at({', '.join(map(repr, shift.tolist()))})" if shift.any() else ""
        if np.array_equal(turn, np.eye(3)):
            return f"{self.child!r}{at or '.at(0.0, 0.0, 0.0)'}{label}"
        for digits in _REPR_DIGITS:
            axis, angle = _axis_angle(turn, digits)
            if axis.any() and np.array_equal(self.child.turned(axis, angle).pose[:3, :3], turn):
                return f"{self.child!r}.turned({tuple(axis.tolist())!r}, {angle!r}){at}{label}"
        return f"{self.child!r}.placed({self.pose.tolist()!r}){label}"

    def _key(self) -> tuple[Csg, bytes, str]:
        return self.child, self.pose.tobytes(), self.name


@dataclass(frozen=True, repr=False)
class Operation(Csg):
    """Two or more solids under one operator; the same operator in first place is taken apart."""

    children: tuple[Csg, ...]
    name: str = ""

    def __post_init__(self) -> None:
        if len(self.children) < 2:
            raise PalpateError("an operation needs two solids or more")
        first, *others = self.children
        if isinstance(first, type(self)) and not first.name:
            object.__setattr__(self, "children", (*first.children, *others))
        else:
            object.__setattr__(self, "children", (first, *others))

    def scaled(self, factor: float) -> Self:
        """Of every child's."""
        return replace(self, children=tuple(child.scaled(factor) for child in self.children))

    def leaves(self, part_from_self: Floats | None = None, adds: bool = True) -> Iterator[Leaf]:
        """All children's; those after the first are turned over in a difference."""
        for i, child in enumerate(self.children):
            yield from child.leaves(part_from_self, adds != (isinstance(self, Difference) and i > 0))

    def _repr(self, symbol: str) -> str:
        label = f".named({self.name!r})" if self.name else ""
        return f"({symbol.join(map(repr, self.children))}){label}"


class Union(Operation):
    """What is in any child."""

    def signed_distance(self, points: Floats) -> Floats:
        """The least: exact outside."""
        return reduce(np.minimum, [c.signed_distance(points) for c in self.children])

    def _bounds(self, part_from_self: Floats) -> Floats:
        boxes = np.stack([c._bounds(part_from_self) for c in self.children])
        return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])

    def __repr__(self) -> str:
        return self._repr(" | ")


class Intersection(Operation):
    """What is in every child."""

    def signed_distance(self, points: Floats) -> Floats:
        """The greatest: exact inside."""
        return reduce(np.maximum, [c.signed_distance(points) for c in self.children])

    def _bounds(self, part_from_self: Floats) -> Floats:
        boxes = np.stack([c._bounds(part_from_self) for c in self.children])
        low, high = boxes[:, 0].max(axis=0), boxes[:, 1].min(axis=0)
        return np.stack([low, np.maximum(low, high)])

    def __repr__(self) -> str:
        return self._repr(" & ")


class Difference(Operation):
    """What is in the first child and in no other."""

    def signed_distance(self, points: Floats) -> Floats:
        """The greatest of the first and the others' outsides: exact inside."""
        first, *others = [c.signed_distance(points) for c in self.children]
        return reduce(np.maximum, [-d for d in others], first)

    def _bounds(self, part_from_self: Floats) -> Floats:
        return self.children[0]._bounds(part_from_self)

    def __repr__(self) -> str:
        return self._repr(" - ")


def times(value: Any, factor: float) -> Any:
    """Lengths, however deep they are nested in tuples, times a positive factor."""
    if not (np.isfinite(factor) and factor > 0):
        raise PalpateError(f"a solid is scaled by a positive number, not {factor!r}")
    return tuple(times(v, factor) for v in value) if isinstance(value, tuple) else factor * value


def _axis_angle(turn: Floats, digits: int) -> tuple[Floats, float]:
    """(3,) axis and angle [rad], rounded; no axis where there is no turn to speak of."""
    vector = rotation_log(turn)
    angle = float(np.linalg.norm(vector))
    axis = vector / angle if angle > 1e-12 else np.zeros(3)
    return np.round(axis, digits) + 0.0, round(angle, digits)


def _compose(a_from_b: Floats, b_from_c: Floats) -> Floats:
    if np.array_equal(a_from_b[:3, :3], np.eye(3)):
        return pose(b_from_c[:3, :3], b_from_c[:3, 3] + a_from_b[:3, 3])
    product: Floats = a_from_b @ b_from_c
    return product
