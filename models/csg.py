"""Constructive solid geometry: cube, cylinder, cone and sphere, combined with `|`, `&`, `-`.

Every primitive is centered at its origin with its axis along z (a cone's bottom is at -height / 2).
Lengths are in mm, angles in rad.  ``repr`` is the Python that builds a tree again:

>>> Cylinder(20.0, 40.0).at(0, 0, 10) - Cube((10.0, 10.0, 99.0))
(Cylinder(20.0, 40.0).at(0.0, 0.0, 10.0) - Cube((10.0, 10.0, 99.0)))
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce

import numpy as np

from models.expression import Csg, Difference, Intersection, Leaf, Operation, Placed, Primitive, Union
from primitives.arrays import Floats
from primitives.errors import PalpateError

__all__ = [
    "Cone",
    "Csg",
    "Cube",
    "Cylinder",
    "Difference",
    "Intersection",
    "Leaf",
    "Operation",
    "Placed",
    "Primitive",
    "Sphere",
    "Union",
]


@dataclass(frozen=True, repr=False)
class Cube(Primitive):
    """A box."""

    size: tuple[float, float, float]  # along x, y, z [mm]
    name: str = ""

    def __post_init__(self) -> None:
        size = tuple(_length(s, "a cube's size") for s in np.ravel(np.asarray(self.size, dtype=float)))
        if len(size) != 3:
            raise PalpateError(f"a cube's size has three lengths (x, y, z), not {len(size)}")
        object.__setattr__(self, "size", size)

    def support(self, directions: Floats) -> Floats:
        """Half the size, absolute."""
        reach: Floats = np.abs(directions) @ (np.array(self.size) / 2)
        return reach

    def signed_distance(self, points: Floats) -> Floats:
        """Of a box."""
        return _box_distance(np.abs(points) - np.array(self.size) / 2)

    def __repr__(self) -> str:
        return f"Cube({self.size!r}" + self._label()


@dataclass(frozen=True, repr=False)
class Cylinder(Primitive):
    """A round bar along z."""

    radius: float  # [mm]
    height: float  # [mm]
    name: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", _length(self.radius, "a cylinder's radius"))
        object.__setattr__(self, "height", _length(self.height, "a cylinder's height"))

    def support(self, directions: Floats) -> Floats:
        """Of two discs."""
        across = np.hypot(directions[:, 0], directions[:, 1])
        reach: Floats = self.radius * across + self.height / 2 * np.abs(directions[:, 2])
        return reach

    def signed_distance(self, points: Floats) -> Floats:
        """Of a rectangle in (rho, z)."""
        rho = np.hypot(points[:, 0], points[:, 1])
        return _box_distance(np.stack([rho - self.radius, np.abs(points[:, 2]) - self.height / 2], axis=1))

    def __repr__(self) -> str:
        return f"Cylinder({self.radius!r}, {self.height!r}" + self._label()


@dataclass(frozen=True, repr=False)
class Cone(Primitive):
    """A cone or frustum along z; a radius of zero is an apex."""

    bottom_radius: float  # [mm] at z = -height / 2
    top_radius: float  # [mm] at z = +height / 2
    height: float  # [mm]
    name: str = ""

    def __post_init__(self) -> None:
        for end in ("bottom_radius", "top_radius"):
            value = float(getattr(self, end))
            object.__setattr__(self, end, value if value == 0 else _length(value, f"a cone's {end}"))
        object.__setattr__(self, "height", _length(self.height, "a cone's height"))
        if self.bottom_radius == self.top_radius:
            raise PalpateError("a cone's two radii must differ; use Cylinder for equal ones")

    def support(self, directions: Floats) -> Floats:
        """The greater of two discs."""
        across, along = np.hypot(directions[:, 0], directions[:, 1]), self.height / 2 * directions[:, 2]
        reach: Floats = np.maximum(self.bottom_radius * across - along, self.top_radius * across + along)
        return reach

    def signed_distance(self, points: Floats) -> Floats:
        """Of a trapezoid in (rho, z): the nearest of bottom, side and top."""
        half = self.height / 2
        q = np.stack([np.hypot(points[:, 0], points[:, 1]), points[:, 2]], axis=1)
        low, high = np.array([self.bottom_radius, -half]), np.array([self.top_radius, half])
        sides = [(np.array([0.0, -half]), low), (low, high), (high, np.array([0.0, half]))]
        away = reduce(np.minimum, [_segment_distance(q, a, b) for a, b in sides])
        share = (q[:, 1] + half) / self.height
        radius = self.bottom_radius + share * (self.top_radius - self.bottom_radius)
        inside = (np.abs(q[:, 1]) <= half) & (q[:, 0] <= radius)
        return np.where(inside, -away, away)

    def __repr__(self) -> str:
        return f"Cone({self.bottom_radius!r}, {self.top_radius!r}, {self.height!r}" + self._label()


@dataclass(frozen=True, repr=False)
class Sphere(Primitive):
    """A ball."""

    radius: float  # [mm]
    name: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", _length(self.radius, "a sphere's radius"))

    def support(self, directions: Floats) -> Floats:
        """The radius."""
        return np.full(len(directions), self.radius)

    def signed_distance(self, points: Floats) -> Floats:
        """To the center, less the radius."""
        distance: Floats = np.linalg.norm(points, axis=1) - self.radius
        return distance

    def __repr__(self) -> str:
        return f"Sphere({self.radius!r}" + self._label()


def _length(value: float, what: str) -> float:
    length = float(value)
    if not (np.isfinite(length) and length > 0):
        raise PalpateError(f"{what} must be a positive length in mm, not {value!r}")
    return length


def _box_distance(beyond: Floats) -> Floats:
    outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
    distance: Floats = outside + np.minimum(beyond.max(axis=1), 0.0)
    return distance


def _segment_distance(q: Floats, a: Floats, b: Floats) -> Floats:
    along = b - a
    length = float(along @ along)
    share = np.clip((q - a) @ along / length, 0.0, 1.0) if length > 0 else np.zeros(len(q))
    distance: Floats = np.linalg.norm(q - a - share[:, None] * along, axis=1)
    return distance
