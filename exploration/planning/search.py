"""Where to look for an object of unknown place: parallel sweeps through the workspace.

The first sweep goes through the middle; the next ones follow Roberts' R2 sequence, whose gaps shrink as the
square root of the number of sweeps, so a large object is met early and a small one in the end.
"""

from collections.abc import Iterator

import numpy as np

from primitives import pose as se3
from primitives.arrays import Floats

_PLASTIC = 1.324717957244746  # the root of x^3 = x + 1


def sweeps(box: Floats, pad: tuple[float, float], most: int = 600) -> Iterator[tuple[Floats, Floats]]:
    """Start and end (4, 4) poses of downward sweeps through a (6,) box [mm] with a pad of (x, y) size [mm]."""
    low, high = box[:3], box[3:]
    middle = (low + high) / 2
    room = np.maximum(high[:2] - low[:2] - np.asarray(pad), 0.0)
    facing_down = np.diag([1.0, -1.0, -1.0])
    for i in range(most):
        u = np.array([(0.5 + i / _PLASTIC) % 1.0, (0.5 + i / _PLASTIC**2) % 1.0])
        x, y = middle[:2] + (u - 0.5) * room
        yield (
            se3.pose(facing_down, [x, y, high[2]]),
            se3.pose(facing_down, [x, y, low[2]]),
        )
