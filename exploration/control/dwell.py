"""Stand still and average: the mean of n frames has noise / sqrt(n)."""

from dataclasses import replace

import numpy as np

from exploration.devices.guard import Guard, Observation
from primitives import pose as se3
from primitives.arrays import Floats, frozen


def dwell(guard: Guard, frames: int = 6) -> Observation:
    """The last observation of `frames`, its image and its pose their means.

    The first frames may come while the stage still brakes: a mean of images is what the mean of their poses sees,
    to first order, not what the last pose does.
    """
    seen = [guard.hold() for _ in range(frames)]
    image = replace(
        seen[-1].image,
        depth=frozen(np.mean([s.image.depth for s in seen], axis=0)),
        sigma=frozen(seen[-1].image.sigma / np.sqrt(frames)),
    )
    return replace(seen[-1], image=image, world_from_sensor=_mean([s.world_from_sensor for s in seen]))


def _mean(poses: list[Floats]) -> Floats:
    """(4, 4) the mean of poses that are near each other."""
    first = poses[0]
    return first @ se3.exp(np.mean(se3.log(se3.inverse(first) @ np.array(poses)), axis=0))
