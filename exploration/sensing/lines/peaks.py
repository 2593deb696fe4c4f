"""Lines that edge points vote for, one after another, each taking its points away (`hough_votes`)."""

from dataclasses import dataclass
from math import hypot
from typing import NamedTuple

import numpy as np

from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.edges import EdgePoints
from exploration.sensing.lines.hough_votes import find_peak, members_of
from exploration.sensing.lines.line import normalized
from exploration.sensing.response import Response
from primitives.arrays import Bools


@dataclass(frozen=True)
class PeakConfig:
    """What counts as a peak."""

    direction_tolerance: float = 0.45  # [rad] of a point's gradient from the line's normal
    band: float = 0.7  # [response widths] within which a point belongs to a line
    least_votes: float = 2.0  # sum of weights
    least_length: float = 1.6  # [taxels] seen


class Peak(NamedTuple):
    """A line, and who voted for it."""

    angle: float  # [rad]
    offset: float  # [mm]
    side: int  # of the material
    members: Bools  # (points,)

    @property
    def straight(self) -> tuple[float, float, float]:
        """Angle [rad], offset [mm] and the material's side."""
        return self.angle, self.offset, float(self.side)


def peaks(
    points: EdgePoints,
    image: TactileImage,
    most: int,
    response: Response,
    config: PeakConfig = PeakConfig(),
) -> tuple[Peak, ...]:
    """Of an image's edge points, most votes first."""
    found: list[Peak] = []
    left = np.array(points.weight)
    reach = 0.5 * hypot(*image.array.size)
    band = config.band * response.mean_width
    least = config.least_length * min(image.array.pitch)
    for _ in range(most):
        if len(points) < 2 or left.sum() < config.least_votes:
            break
        angle, offset = find_peak(points.points, points.directions, left, reach, config.direction_tolerance)
        members, votes, length, toward = members_of(
            points.points, points.directions, left, angle, offset, band, config.direction_tolerance
        )
        if votes < config.least_votes:
            break
        left[members] = 0.0
        if length >= least:
            angle, offset, side = normalized(angle, offset, 1 if toward > 0 else -1)
            found.append(Peak(angle, offset, side, members))
    return tuple(found)
