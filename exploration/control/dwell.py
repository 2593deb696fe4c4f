"""Stand still and average: the mean of n frames has noise / sqrt(n)."""

from dataclasses import replace

import numpy as np

from exploration.devices.guard import Guard, Observation
from primitives.arrays import frozen


def dwell(guard: Guard, frames: int = 6) -> Observation:
    """The last observation of `frames`, its image their mean."""
    first = guard.hold()
    images = [first.image]
    seen = first
    for _ in range(frames - 1):
        seen = guard.hold()
        images.append(seen.image)
    depth = np.mean([image.depth for image in images], axis=0)
    image = replace(seen.image, depth=frozen(depth), sigma=frozen(seen.image.sigma / np.sqrt(len(images))))
    return replace(seen, image=image)
