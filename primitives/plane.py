"""A plane: the half space behind it is solid.  Distance = (p - origin) . normal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from primitives.arrays import Floats
from primitives.rays import linear_roots
from primitives.revolution import Profile, Revolution, point, unit


@dataclass(frozen=True, eq=False)
class Plane(Revolution):
    """Local step: (along the normal [mm], tilts toward t1, t2 [rad]), turned about the origin."""

    origin: Floats  # (3,) [mm] a point of it
    normal: Floats  # (3,) outward unit normal

    kind: ClassVar[str] = "plane"
    dof: ClassVar[int] = 3
    translations: ClassVar[tuple[int, ...]] = (2,)
    tilts: ClassVar[int] = 2

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", point(self.origin, "a plane's origin"))
        object.__setattr__(self, "normal", unit(self.normal, "a plane's normal"))

    @property
    def anchor(self) -> Floats:
        """The origin."""
        return self.origin

    @property
    def direction(self) -> Floats:
        """The normal."""
        return self.normal

    @property
    def sizes(self) -> tuple[float, ...]:
        """None."""
        return ()

    def with_parts(self, anchor: Floats, direction: Floats, sizes: tuple[float, ...]) -> Self:
        """A plane from origin and normal."""
        return type(self)(anchor, direction)

    def profile(self, rho: Floats, z: Floats) -> Profile:
        """A line across the axis."""
        zero, none = np.zeros_like(z), np.empty((len(z), 0))
        return Profile(z, zero, np.ones_like(z), zero, zero, none, none)

    def signed_distance(self, points: Floats) -> Floats:
        """The height of (n, 3) points [mm] over it: (n,) [mm], without a profile."""
        return np.asarray((points - self.origin) @ self.normal)

    def normals(self, points: Floats) -> Floats:
        """Its own normal, at each of (n, 3) points."""
        return np.tile(self.normal, (len(points), 1))

    def roots(self, origins: Floats, directions: Floats) -> Floats:
        """At most one."""
        return linear_roots(directions[:, 2], origins[:, 2])

    def area(self, extent: tuple[float, float] | None = None) -> float:
        """Of a rectangle of (length, width) [mm]."""
        return np.inf if extent is None else extent[0] * extent[1]

    def _anchor_step(self, anchor: Floats, axis: Floats, frame: Floats) -> Floats:
        return np.array([(anchor - self.origin) @ axis / (self.normal @ axis)])
