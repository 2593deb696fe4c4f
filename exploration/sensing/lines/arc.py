"""A circular edge in one frame: the rim of a disc or boss (material inside), or of a hole (material outside).

An arc of infinite radius is a line; beyond `LONGEST` the two are not told apart on any pad, and it is called one.
"""

from dataclasses import dataclass
from math import sqrt

import numpy as np

from primitives.arrays import Floats

LONGEST = 400.0  # [mm]


@dataclass(frozen=True)
class Arc:
    """A circular edge, with the evidence for it."""

    center: Floats  # (2,) [mm] from the pad's center; often off the pad
    radius: float  # [mm]
    covariance: Floats  # (3, 3) of (center x, center y, radius)
    material_inside: bool  # a disc or boss; a hole otherwise
    span: float  # [rad] of the circle seen; 2 pi where the pad holds it whole
    strength: float  # the step's height in standard deviations of its estimate
    plateau: float  # [mm] depth of the material beside the rim, at the middle of what is seen

    @property
    def radius_sigma(self) -> float:
        """[mm]."""
        return sqrt(float(self.covariance[2, 2]))

    def distance(self, points: Floats) -> Floats:
        """(n,) signed distance [mm] of (n, 2) points, positive in the material."""
        inward: Floats = self.radius - np.linalg.norm(points - self.center, axis=1)
        return inward if self.material_inside else -inward
