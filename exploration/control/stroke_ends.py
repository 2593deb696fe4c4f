"""What ends a stroke ahead of the pad: an edge, a rise, the end of the stage's reach."""

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
    ahead = image.array.x[None, :] * heading[0] + image.array.y[:, None] * heading[1] > 0.0
    live = np.where(np.isfinite(image.sigma) & ahead, image.depth, 0.0)
    mean = 0.25 * (live[1:, 1:] + live[:-1, 1:] + live[1:, :-1] + live[:-1, :-1])
    return bool(mean.max(initial=0.0) > depth)


def leaves(guard: Guard, seen: Observation, heading: Floats, speed: float, room: float) -> bool:
    """Whether going on along a (2,) heading would soon end the stage's reach."""
    going = seen.world_from_sensor[:3, :2] @ heading
    stop = speed * (guard.pending.latency + 2.0 * guard.period) + speed**2 / (
        2.0 * guard.stage.limits.acceleration
    )
    there = seen.world_from_sensor[:3, 3] + (room + stop) * going
    low, high = np.array(guard.limits.reach[:3]), np.array(guard.limits.reach[3:])
    return bool((((there < low) & (going < 0.0)) | ((there > high) & (going > 0.0))).any())
