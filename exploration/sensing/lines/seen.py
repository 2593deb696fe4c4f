"""What of a line or a circle the pad sees as the end of the face: where the face is on one side of it only."""

from math import atan2, hypot

import numpy as np

from exploration.sensing.lines.line import clipped
from exploration.sensing.lines.region import Region
from primitives.arrays import Floats

SAMPLES = 96  # along a line or a circle
BESIDE = 0.05  # [mm]


def seen_of_line(
    region: Region, parameters: Floats, angle: float, offset: float, size: tuple[float, float]
) -> tuple[float, float]:
    """The stretch [mm] along a line where the face ends at it, on a pad of this size; (0, 0) if nowhere."""
    low, high = clipped(angle, offset, (size[0] / 2, size[1] / 2))
    if high <= low:
        return 0.0, 0.0
    e = np.array([np.cos(angle), np.sin(angle)])
    n = np.array([-e[1], e[0]])
    along = low + (np.arange(SAMPLES) + 0.5) * (high - low) / SAMPLES
    at = along[:, None] * e + offset * n
    border = region.holds(at + BESIDE * n, parameters) != region.holds(at - BESIDE * n, parameters)
    if not border.any():
        return 0.0, 0.0
    half = 0.5 * (high - low) / SAMPLES
    return float(along[border][0]) - half, float(along[border][-1]) + half


def seen_of_disc(
    region: Region, parameters: Floats, disc: Floats, size: tuple[float, float]
) -> tuple[Floats, float]:
    """(n,) angles [rad], evenly spaced, at which a circle on the pad is the face's end; and their spacing."""
    cx, cy, radius = disc.tolist()
    toward, half = atan2(-cy, -cx), np.pi  # what leaves the pad does so away from its middle
    if hypot(cx, cy) + hypot(*size) / 2 < 3 * radius:
        half = min(np.pi, 1.2 * hypot(*size) / radius)
    step = 2.0 * half / SAMPLES
    turn = toward - half + (np.arange(SAMPLES) + 0.5) * step
    out = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    at = disc[:2] + radius * out
    on_pad = (np.abs(at[:, 0]) < size[0] / 2) & (np.abs(at[:, 1]) < size[1] / 2)
    beside = region.holds(at + BESIDE * out, parameters) != region.holds(at - BESIDE * out, parameters)
    return turn[on_pad & beside], step
