"""What ends a stroke ahead of the pad: an edge, a rise, the end of the stage's reach."""

import numba
import numpy as np

from exploration.devices.guard import Guard, Observation
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.line import Line
from primitives.arrays import Floats


def edge_near(lines: tuple[Line, ...], heading: Floats, image: TactileImage, share: float) -> bool:
    """Whether a line with the material behind it lies within a share of the half pad ahead."""
    half = 0.5 * float(np.abs(heading) @ np.asarray(image.array.size))
    for line in lines:
        facing = -float(line.inward @ heading)
        if facing > 0.4:
            ahead = float(line.distance(np.zeros((1, 2)))[0]) / facing
            if ahead < share * half:
                return True
    return False


def rises(image: TactileImage, heading: Floats, depth: float) -> bool:
    """Whether the surface stands `depth` [mm] up into the pad's front half, as at the foot of a wall."""
    array = image.array
    return bool(_highest(image.depth, image.sigma, array.x, array.y, heading[0], heading[1]) > depth)


@numba.njit(cache=True, error_model="numpy")
def _highest(depth: Floats, sigma: Floats, x: Floats, y: Floats, along_x: float, along_y: float) -> float:
    """[mm] greatest mean of 2 x 2 taxels, of those that are dead or behind the pad's middle as zero."""
    live = np.zeros(depth.shape)
    for i in range(len(y)):
        for j in range(len(x)):
            if sigma[i, j] < np.inf and x[j] * along_x + y[i] * along_y > 0.0:
                live[i, j] = depth[i, j]
    most = 0.0
    for i in range(len(y) - 1):
        for j in range(len(x) - 1):
            most = max(most, 0.25 * (live[i + 1, j + 1] + live[i, j + 1] + live[i + 1, j] + live[i, j]))
    return most


def leaves(guard: Guard, seen: Observation, heading: Floats, speed: float, room: float) -> bool:
    """Whether going on along a (2,) heading would soon end the stage's reach."""
    going = seen.world_from_sensor[:3, :2] @ heading
    stop = speed * (guard.pending.latency + 2.0 * guard.period) + speed**2 / (
        2.0 * guard.stage.limits.acceleration
    )
    there = seen.world_from_sensor[:3, 3] + (room + stop) * going
    low, high = np.array(guard.limits.reach[:3]), np.array(guard.limits.reach[3:])
    return bool((((there < low) & (going < 0.0)) | ((there > high) & (going > 0.0))).any())
