"""A ring whose tube is round: distance = hypot(rho - major_radius, z) - minor_radius."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.leaves.distances import positive_length
from models.leaves.expression import Primitive
from primitives.arrays import Floats
from primitives.errors import PalpateError


@dataclass(frozen=True, repr=False)
class Torus(Primitive):
    """A ring round z."""

    major_radius: float  # [mm] of the circle along which the tube runs
    minor_radius: float  # [mm] of the tube
    name: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "major_radius", positive_length(self.major_radius, "a torus's major radius"))
        object.__setattr__(self, "minor_radius", positive_length(self.minor_radius, "a torus's minor radius"))
        if self.minor_radius >= self.major_radius:
            raise PalpateError("a torus's minor radius must be less than its major radius, to leave a hole")

    def support(self, directions: Floats) -> Floats:
        """Of the circle, and the tube's radius."""
        reach: Floats = self.major_radius * np.hypot(directions[:, 0], directions[:, 1]) + self.minor_radius
        return reach

    def signed_distance(self, points: Floats) -> Floats:
        """To the circle, less the tube's radius."""
        rho = np.hypot(points[:, 0], points[:, 1])
        distance: Floats = np.hypot(rho - self.major_radius, points[:, 2]) - self.minor_radius
        return distance

    def __repr__(self) -> str:
        return f"Torus({self.major_radius!r}, {self.minor_radius!r}" + self._label()
