"""One nappe of a circular cone.  Distance = rho cos(a) - z sin(a); behind the apex, that to the apex."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from primitives.arrays import Floats
from primitives.rays import quadratic_roots
from primitives.revolution import TINY, Profile, Revolution, point, size, unit


@dataclass(frozen=True, eq=False)
class Cone(Revolution):
    """Local step: (along t1, t2, axis [mm], tilts [rad], semi-angle [rad]), turned about the apex."""

    apex: Floats  # (3,) [mm]
    axis: Floats  # (3,) unit, from the apex into the cone
    semi_angle: float  # [rad] between axis and generator, in (0, pi/2)

    kind: ClassVar[str] = "cone"
    dof: ClassVar[int] = 6
    translations: ClassVar[tuple[int, ...]] = (0, 1, 2)
    tilts: ClassVar[int] = 2

    def __post_init__(self) -> None:
        object.__setattr__(self, "apex", point(self.apex, "a cone's apex"))
        object.__setattr__(self, "axis", unit(self.axis, "a cone's axis"))
        object.__setattr__(self, "semi_angle", size(self.semi_angle, "a cone's semi-angle", np.pi / 2))

    @property
    def anchor(self) -> Floats:
        """The apex."""
        return self.apex

    @property
    def direction(self) -> Floats:
        """The axis."""
        return self.axis

    @property
    def sizes(self) -> tuple[float, ...]:
        """(semi_angle,)."""
        return (self.semi_angle,)

    def with_parts(self, anchor: Floats, direction: Floats, sizes: tuple[float, ...]) -> Self:
        """A cone from apex, axis and (semi_angle,)."""
        return type(self)(anchor, direction, sizes[0])

    def profile(self, rho: Floats, z: Floats) -> Profile:
        """A half line from the apex."""
        c, s = np.cos(self.semi_angle), np.sin(self.semi_angle)
        slant = rho * s + z * c
        distance, radial, axial = rho * c - z * s, np.full_like(z, c), np.full_like(z, -s)
        bend, by_angle, turn = np.zeros_like(z), -slant, np.full_like(z, -1.0)
        behind = slant < 0
        if behind.any():
            far = np.maximum(np.sqrt(rho**2 + z**2), TINY)
            distance = np.where(behind, far, distance)
            radial, axial = np.where(behind, rho / far, radial), np.where(behind, z / far, axial)
            bend, by_angle = np.where(behind, 1.0 / far, bend), np.where(behind, 0.0, by_angle)
            turn = np.where(behind, 0.0, turn)
        around = radial / np.maximum(rho, TINY)
        return Profile(distance, radial, axial, bend, around, by_angle[:, None], turn[:, None])

    def roots(self, origins: Floats, directions: Floats) -> Floats:
        """At most two on the nappe."""
        weight = np.array([1.0, 1.0, -(np.tan(self.semi_angle) ** 2)])
        a, b, c = (
            (x * y) @ weight for x, y in ((directions, directions), (origins, directions), (origins, origins))
        )
        t = quadratic_roots(a, b, c)
        height = origins[:, 2, None] + np.where(np.isfinite(t), t, 0.0) * directions[:, 2, None]
        return np.where(height >= 0, t, np.inf)

    def area(self, extent: tuple[float, float] | None = None) -> float:
        """Of the whole round between two distances from the apex, along the axis [mm]."""
        if extent is None:
            return np.inf
        ring = abs(extent[1] ** 2 - extent[0] ** 2)
        return float(np.pi * np.tan(self.semi_angle) / np.cos(self.semi_angle) * ring)
