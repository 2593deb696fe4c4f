"""A sphere.  Distance = |p - center| - radius."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from primitives.arrays import Floats, frozen
from primitives.rays import quadratic_roots
from primitives.revolution import TINY, Profile, Revolution, point, size

_UP = frozen([0.0, 0.0, 1.0])
_WORLD = frozen(np.eye(3))


@dataclass(frozen=True, eq=False)
class Sphere(Revolution):
    """Local step: (along x, y, z [mm], radius [mm])."""

    center: Floats  # (3,) [mm]
    radius: float  # [mm]

    kind: ClassVar[str] = "sphere"
    dof: ClassVar[int] = 4
    translations: ClassVar[tuple[int, ...]] = (0, 1, 2)
    tilts: ClassVar[int] = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", point(self.center, "a sphere's center"))
        object.__setattr__(self, "radius", size(self.radius, "a sphere's radius"))

    @property
    def anchor(self) -> Floats:
        """The center."""
        return self.center

    @property
    def direction(self) -> Floats:
        """World z: a sphere has no axis of its own."""
        return _UP

    @property
    def frame(self) -> Floats:
        """The world's."""
        return _WORLD

    @property
    def sizes(self) -> tuple[float, ...]:
        """(radius,)."""
        return (self.radius,)

    def with_parts(self, anchor: Floats, direction: Floats, sizes: tuple[float, ...]) -> Self:
        """A sphere from center and (radius,)."""
        return type(self)(anchor, sizes[0])

    def profile(self, rho: Floats, z: Floats) -> Profile:
        """An arc about the center."""
        far = np.sqrt(rho**2 + z**2)
        safe = np.maximum(far, TINY)
        axial = np.where(far > TINY, z / safe, 1.0)
        column = np.ones((len(z), 1))
        return Profile(far - self.radius, rho / safe, axial, 1.0 / safe, 1.0 / safe, -column, 0.0 * column)

    def roots(self, origins: Floats, directions: Floats) -> Floats:
        """At most two."""
        b, c = (origins * directions).sum(axis=1), (origins * origins).sum(axis=1) - self.radius**2
        return quadratic_roots(np.ones_like(b), b, c)

    def area(self, extent: tuple[float, float] | None = None) -> float:
        """Of a cap of (diameter of its rim circle, height) [mm]; the whole without extent."""
        height = 2 * self.radius if extent is None else extent[1]
        return float(2 * np.pi * self.radius * height)
