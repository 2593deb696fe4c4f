"""Constructive solid geometry: cube, cylinder, cone, sphere, torus, prism and polyhedron under `|`, `&`, `-`.

Every primitive is centered at its origin with its axis along z (a cone's bottom is at -height / 2), except that
a prism's outline and a polyhedron's points lie where they are given.
Lengths are in mm, angles in rad.  ``repr`` is the Python that builds a tree again:

>>> Cylinder(20.0, 40.0).at(0, 0, 10) - Cube((10.0, 10.0, 99.0))
(Cylinder(20.0, 40.0).at(0.0, 0.0, 10.0) - Cube((10.0, 10.0, 99.0)))
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce

import numpy as np

from models.leaves.distances import box_distance, positive_length, segment_distance
from models.leaves.expression import Csg, Difference, Intersection, Leaf, Operation, Placed, Primitive, Union
from models.leaves.polyhedron import Polyhedron
from models.leaves.prism import Prism
from models.leaves.torus import Torus
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
    "Polyhedron",
    "Primitive",
    "Prism",
    "Sphere",
    "Torus",
    "Union",
]


@dataclass(frozen=True, repr=False)
class Cube(Primitive):
    """A box."""

    size: tuple[float, float, float]  # along x, y, z [mm]
    name: str = ""

    def __post_init__(self) -> None:
        size = tuple(
            positive_length(s, "a cube's size") for s in np.ravel(np.asarray(self.size, dtype=float))
        )
        if len(size) != 3:
            raise PalpateError(f"a cube's size has three lengths (x, y, z), not {len(size)}")
        object.__setattr__(self, "size", size)

    def support(self, directions: Floats) -> Floats:
        """Half the size, absolute."""
        reach: Floats = np.abs(directions) @ (np.array(self.size) / 2)
        return reach

    def signed_distance(self, points: Floats) -> Floats:
        """Of a box."""
        return box_distance(np.abs(points) - np.array(self.size) / 2)

    def __repr__(self) -> str:
        return f"Cube({self.size!r}" + self._label()


@dataclass(frozen=True, repr=False)
class Cylinder(Primitive):
    """A round bar along z."""

    radius: float  # [mm]
    height: float  # [mm]
    name: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", positive_length(self.radius, "a cylinder's radius"))
        object.__setattr__(self, "height", positive_length(self.height, "a cylinder's height"))

    def support(self, directions: Floats) -> Floats:
        """Of two discs."""
        across = np.hypot(directions[:, 0], directions[:, 1])
        reach: Floats = self.radius * across + self.height / 2 * np.abs(directions[:, 2])
        return reach

    def signed_distance(self, points: Floats) -> Floats:
        """Of a rectangle in (rho, z)."""
        rho = np.hypot(points[:, 0], points[:, 1])
        return box_distance(np.stack([rho - self.radius, np.abs(points[:, 2]) - self.height / 2], axis=1))

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
            object.__setattr__(self, end, value if value == 0 else positive_length(value, f"a cone's {end}"))
        object.__setattr__(self, "height", positive_length(self.height, "a cone's height"))
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
        away = reduce(np.minimum, [segment_distance(q, a, b) for a, b in sides])
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
        object.__setattr__(self, "radius", positive_length(self.radius, "a sphere's radius"))

    def support(self, directions: Floats) -> Floats:
        """The radius."""
        return np.full(len(directions), self.radius)

    def signed_distance(self, points: Floats) -> Floats:
        """To the center, less the radius."""
        distance: Floats = np.linalg.norm(points, axis=1) - self.radius
        return distance

    def __repr__(self) -> str:
        return f"Sphere({self.radius!r}" + self._label()
