"""A line in the pad's image as an edge of the object in the world."""

from dataclasses import dataclass

import numpy as np

from exploration.devices.guard import Observation
from exploration.sensing.line import Line
from primitives.arrays import Floats


@dataclass(frozen=True)
class Sighting:
    """An edge, seen once from one face."""

    point: Floats  # (3,) [mm] on the edge, nearest to the pad's center
    tangent: Floats  # (3,) unit direction along the edge
    outward: Floats  # (3,) unit direction in the face's plane, away from the material
    normal: Floats  # (3,) outward normal of the face that it was seen from
    sigma: float  # [mm] across the edge
    length: float  # [mm] seen


def sight(line: Line, seen: Observation) -> Sighting:
    """The world's edge of a line in an observation's image."""
    foot = line.offset * line.normal
    lift = seen.world_from_sensor
    turn = lift[:3, :3]
    return Sighting(
        point=turn @ np.array([foot[0], foot[1], -line.plateau]) + lift[:3, 3],
        tangent=turn[:, :2] @ line.direction,
        outward=-turn[:, :2] @ line.inward,
        normal=-turn[:, 2],
        sigma=float(np.sqrt(line.covariance[1, 1])),
        length=line.length,
    )
