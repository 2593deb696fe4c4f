"""A straight edge in one frame.

Its direction is (cos a, sin a) with 0 <= a < pi; its offset is measured from the pad's center along
(-sin a, cos a); (a, rho) and (a - pi, -rho) are the same line, and `normalized` picks the first.
"""

from dataclasses import dataclass

import numpy as np

from primitives.arrays import Floats


@dataclass(frozen=True)
class Line:
    """An edge, with the evidence for it."""

    angle: float  # [rad] of its direction, in [0, pi)
    offset: float  # [mm] along (-sin, cos) of the angle
    covariance: Floats  # (2, 2) of (angle, offset)
    length: float  # [mm] seen
    start: Floats  # (2,) [mm] end with the lesser coordinate along the direction
    end: Floats  # (2,) [mm]
    strength: float  # the step's height in standard deviations of its estimate
    material_side: int  # +1 if the material lies on the positive side of the offset direction
    plateau: float  # [mm] depth of the material beside the edge, at the middle of what is seen

    @property
    def direction(self) -> Floats:
        """(2,) unit vector along the line."""
        return np.array([np.cos(self.angle), np.sin(self.angle)])

    @property
    def normal(self) -> Floats:
        """(2,) unit vector of positive offset."""
        return np.array([-np.sin(self.angle), np.cos(self.angle)])

    @property
    def inward(self) -> Floats:
        """(2,) unit vector into the material."""
        return self.material_side * self.normal

    def distance(self, points: Floats) -> Floats:
        """(n,) signed distance [mm] of (n, 2) points, positive in the material."""
        away: Floats = self.material_side * (points @ self.normal - self.offset)
        return away


def normalized(angle: float, offset: float, side: int) -> tuple[float, float, int]:
    """The same line with its angle in [0, pi)."""
    turns = int(np.floor(angle / np.pi))
    sign = -1 if turns % 2 else 1
    angle = max(0.0, angle - turns * np.pi)
    if angle >= np.pi:
        angle, sign = 0.0, -sign
    return angle, sign * offset, sign * side


def clipped(angle: float, offset: float, half_size: tuple[float, float]) -> tuple[float, float]:
    """Where along its direction [mm] the line enters and leaves a pad of this half size; (0, 0) if it misses."""
    low, high = -np.inf, np.inf
    direction = np.cos(angle), np.sin(angle)
    foot = -offset * np.sin(angle), offset * np.cos(angle)
    for p, d, half in zip(foot, direction, half_size, strict=True):
        if abs(d) < 1e-12:
            if abs(p) > half:
                return 0.0, 0.0
            continue
        a, b = (-half - p) / d, (half - p) / d
        low, high = max(low, min(a, b)), min(high, max(a, b))
    return (low, high) if high > low else (0.0, 0.0)
