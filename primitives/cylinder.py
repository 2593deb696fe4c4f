"""An endless circular cylinder.  Distance = rho - radius."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from primitives.arrays import Floats
from primitives.rays import quadratic_roots
from primitives.revolution import TINY, Profile, Revolution, point, size, unit


@dataclass(frozen=True, eq=False)
class Cylinder(Revolution):
    """Local step: (along t1, t2 [mm], tilts toward t1, t2 [rad], radius [mm]), turned about the origin."""

    origin: Floats  # (3,) [mm] a point of the axis
    axis: Floats  # (3,) unit
    radius: float  # [mm]

    kind: ClassVar[str] = "cylinder"
    dof: ClassVar[int] = 5
    translations: ClassVar[tuple[int, ...]] = (0, 1)
    tilts: ClassVar[int] = 2

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", point(self.origin, "a cylinder's origin"))
        object.__setattr__(self, "axis", unit(self.axis, "a cylinder's axis"))
        object.__setattr__(self, "radius", size(self.radius, "a cylinder's radius"))

    @property
    def anchor(self) -> Floats:
        """The origin."""
        return self.origin

    @property
    def direction(self) -> Floats:
        """The axis."""
        return self.axis

    @property
    def sizes(self) -> tuple[float, ...]:
        """(radius,)."""
        return (self.radius,)

    def with_parts(self, anchor: Floats, direction: Floats, sizes: tuple[float, ...]) -> Self:
        """A cylinder from origin, axis and (radius,)."""
        return type(self)(anchor, direction, sizes[0])

    def profile(self, rho: Floats, z: Floats) -> Profile:
        """A line along the axis."""
        zero, one, column = np.zeros_like(z), np.ones_like(z), np.ones((len(z), 1))
        return Profile(rho - self.radius, one, zero, zero, 1.0 / np.maximum(rho, TINY), -column, 0.0 * column)

    def roots(self, origins: Floats, directions: Floats) -> Floats:
        """At most two."""
        o, d = origins[:, :2], directions[:, :2]
        a, b = (d * d).sum(axis=1), (o * d).sum(axis=1)
        return quadratic_roots(a, b, (o * o).sum(axis=1) - self.radius**2)

    def area(self, extent: tuple[float, float] | None = None) -> float:
        """Of a patch of (length along the axis, arc length round it) [mm]."""
        return np.inf if extent is None else extent[0] * extent[1]

    def _aligned(self, axis: Floats) -> Floats:
        return axis if axis @ self.axis >= 0 else -axis

    def _anchor_step(self, anchor: Floats, axis: Floats, frame: Floats) -> Floats:
        offset = anchor - self.origin
        offset = offset - axis * (offset @ self.axis) / (axis @ self.axis)
        moved: Floats = frame[:, :2].T @ offset
        return moved
