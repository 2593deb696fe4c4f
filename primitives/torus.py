"""A torus.  Distance = hypot(rho - radius, z) - minor_radius.

Where minor_radius > radius the tube overlaps itself: the distance is then exact outside the solid, and
measured to the nearer half of the tube inside it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from primitives.arrays import Floats
from primitives.rays import quartic_roots
from primitives.revolution import TINY, Profile, Revolution, point, size, unit


@dataclass(frozen=True, eq=False)
class Torus(Revolution):
    """Local step: (along t1, t2, axis [mm], tilts [rad], the two radii [mm]), turned about the center."""

    center: Floats  # (3,) [mm]
    axis: Floats  # (3,) unit
    radius: float  # [mm] of the circle along which the tube runs
    minor_radius: float  # [mm] of the tube

    kind: ClassVar[str] = "torus"
    dof: ClassVar[int] = 7
    translations: ClassVar[tuple[int, ...]] = (0, 1, 2)
    tilts: ClassVar[int] = 2

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", point(self.center, "a torus's center"))
        object.__setattr__(self, "axis", unit(self.axis, "a torus's axis"))
        object.__setattr__(self, "radius", size(self.radius, "a torus's radius"))
        object.__setattr__(self, "minor_radius", size(self.minor_radius, "a torus's minor radius"))

    @property
    def anchor(self) -> Floats:
        """The center."""
        return self.center

    @property
    def direction(self) -> Floats:
        """The axis."""
        return self.axis

    @property
    def sizes(self) -> tuple[float, ...]:
        """(radius, minor_radius)."""
        return (self.radius, self.minor_radius)

    def with_parts(self, anchor: Floats, direction: Floats, sizes: tuple[float, ...]) -> Self:
        """A torus from center, axis and (radius, minor_radius)."""
        return type(self)(anchor, direction, sizes[0], sizes[1])

    def profile(self, rho: Floats, z: Floats) -> Profile:
        """An arc about (radius, 0)."""
        across = rho - self.radius
        far = np.sqrt(across**2 + z**2)
        safe = np.maximum(far, TINY)
        radial, axial = np.where(far > TINY, across / safe, 1.0), z / safe
        around = radial / np.maximum(rho, TINY)
        by_size = np.stack([-radial, np.full_like(z, -1.0)], axis=1)
        turn = np.stack([axial / safe, np.zeros_like(z)], axis=1)
        return Profile(far - self.minor_radius, radial, axial, 1.0 / safe, around, by_size, turn)

    def roots(self, origins: Floats, directions: Floats) -> Floats:
        """At most four: (|p|^2 + R^2 - r^2)^2 = 4 R^2 (x^2 + y^2), in units of the outer radius."""
        scale = self.radius + self.minor_radius
        big, small = self.radius / scale, self.minor_radius / scale
        o, d = origins / scale, directions
        b = (o * d).sum(axis=1)
        c = (o * o).sum(axis=1) + big**2 - small**2
        dd, od, oo = ((x[:, :2] * y[:, :2]).sum(axis=1) for x, y in ((d, d), (o, d), (o, o)))
        ring = 4 * big**2
        return scale * quartic_roots(
            np.stack(
                [4 * b, 4 * b**2 + 2 * c - ring * dd, 4 * b * c - 2 * ring * od, c**2 - ring * oo], axis=1
            )
        )

    def area(self, extent: tuple[float, float] | None = None) -> float:
        """Of a patch of (arc round the tube, arc round the axis) [mm]; the whole without extent."""
        tube, ring = (2 * np.pi * self.minor_radius, 2 * np.pi * self.radius) if extent is None else extent
        return float(tube * ring)

    def _aligned(self, axis: Floats) -> Floats:
        return axis if axis @ self.axis >= 0 else -axis
