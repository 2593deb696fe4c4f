"""Approach: a guarded straight move until the skin feels something (Dario's first subroutine).

Property class: none; it is how every other procedure begins.
"""

from dataclasses import dataclass

import numpy as np

from exploration.devices.guard import Guard, Observation
from exploration.sensing.frame import TactileImage
from primitives import pose as se3
from primitives.arrays import Floats


@dataclass(frozen=True)
class ApproachConfig:
    """When a frame counts as contact, and how fast the pad may close in."""

    speed: float = 25.0  # [mm/s] the stage must stop within the rubber
    tick: float = 0.6  # [mm] of travel in one, at most, however slow the array is read
    search_speed: float = 50.0  # [mm/s] through space that has not been seen yet
    sigmas: float = 6.0  # a taxel is touched above this many standard deviations of its noise
    taxels: int = 2  # as many neighbors must be touched, so that noise alone starts nothing


def touched(image: TactileImage, config: ApproachConfig = ApproachConfig()) -> bool:
    """Whether the frame shows contact: neighbors that together stand far out of the noise.

    Sums over 3 x 3 taxels are compared with their own standard deviation.
    """
    live = np.isfinite(image.sigma)
    if not live.any():
        return False
    sigma = float(np.median(image.sigma[live]))
    depth = np.where(live, image.depth, 0.0)
    pad = np.pad(depth, 1)
    r, c = depth.shape
    total = sum(pad[i : i + r, j : j + c] for i in range(3) for j in range(3))
    return bool(np.max(total) > config.sigmas * 3.0 * sigma)


def advance(
    guard: Guard,
    direction: Floats,
    distance: float,
    speed: float,
    config: ApproachConfig = ApproachConfig(),
) -> Observation | None:
    """Move at most `distance` [mm] along a (3,) world direction, attitude held; the observation that touched."""
    start = guard.world_from_sensor[:3, 3]
    speed = min(speed, config.tick / guard.period)
    while True:
        here = guard.world_from_sensor
        if float((here[:3, 3] - start) @ direction) >= distance:
            guard.hold()
            return None
        twist = np.zeros(6)
        twist[:3] = here[:3, :3].T @ (direction * speed)
        seen = guard.move(twist)
        if touched(seen.image, config):
            return guard.hold()


def retreat(guard: Guard, distance: float = 6.0) -> None:
    """Back straight off along the pad's own normal, which is free because the pad came from there."""
    guard.go_to(guard.world_from_sensor @ se3.pose(translation=[0.0, 0.0, -distance]))
