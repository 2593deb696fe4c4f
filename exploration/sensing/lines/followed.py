"""An edge that is followed from frame to frame: as it is expected, and as a frame shows it."""

from dataclasses import dataclass
from functools import cached_property
from math import cos, sin

import numpy as np

from primitives.arrays import Floats


@dataclass(frozen=True)
class Expected:
    """Where an edge should be: the last fit, moved by what the pad has moved since."""

    angle: float  # [rad] of the direction of travel, any turn
    offset: float  # [mm] along (-sin, cos) of the angle
    side: int  # of the material
    bend: float = 0.0  # [1/mm] curvature of the edge, positive toward the material
    bend_sigma: float = 1e-6  # [1/mm]
    reach: float = np.inf  # [mm] along the edge, either way, that is fitted


@dataclass(frozen=True)
class Followed:
    """The edge in one frame, in the direction of travel; false where it was lost."""

    parameters: Floats  # (6,) angle [rad], offset [mm], plateau [mm], slope inward, slope along, bend [1/mm]
    covariance: Floats  # (6, 6) of them
    side: int
    misfit: float  # chi2 per degree of freedom
    ends: Floats  # (5,) `ahead`, `behind`, `opens`, `width`, and how far across was looked
    contact: Floats  # (3,) `area`, `centroid`
    found: bool

    def __bool__(self) -> bool:
        return self.found

    @property
    def angle(self) -> float:
        """[rad]."""
        return float(self.parameters[0])

    @property
    def offset(self) -> float:
        """[mm] along (-sin, cos) of the angle."""
        return float(self.parameters[1])

    @property
    def plateau(self) -> float:
        """[mm] depth of the face at the edge, beside the pad's center."""
        return float(self.parameters[2])

    @property
    def bend(self) -> float:
        """[1/mm]."""
        return float(self.parameters[5])

    @property
    def ahead(self) -> float:
        """[mm] from the pad's center, along the edge, to where the face ends; inf: not seen."""
        return float(self.ends[0])

    @property
    def behind(self) -> float:
        """[mm] the same, backward."""
        return float(self.ends[1])

    @property
    def opens(self) -> float:
        """[mm] ahead, to where material begins outside; inf: none."""
        return float(self.ends[2])

    @property
    def width(self) -> float:
        """[mm] from the edge to where the face ends opposite; inf: not seen."""
        return float(self.ends[3])

    @property
    def area(self) -> float:
        """[mm^2] in contact."""
        return float(self.contact[0])

    @property
    def centroid(self) -> Floats:
        """(2,) [mm] of the contact."""
        return self.contact[1:]

    @cached_property
    def direction(self) -> Floats:
        """(2,) unit vector of travel."""
        return np.array([cos(self.angle), sin(self.angle)])

    @cached_property
    def inward(self) -> Floats:
        """(2,) unit vector into the material."""
        return self.side * np.array([-sin(self.angle), cos(self.angle)])

    @property
    def slope(self) -> Floats:
        """(2,) of the face's depth, in the pad's axes."""
        out: Floats = self.parameters[3] * self.inward + self.parameters[4] * self.direction
        return out

    @property
    def foot(self) -> Floats:
        """(2,) [mm] the point of the edge beside the pad's center."""
        return self.side * self.offset * self.inward
