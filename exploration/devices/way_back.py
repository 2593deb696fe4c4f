"""The way that an array came, which is free: back along it leads off whatever it met.

Who meets something a few ticks after backing off stands where there is no room: then it goes back farther, over
what it had come before, and farther each time, until it is out in the open where it came from.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from primitives.arrays import Floats

_OFF = 0.3  # cosine of a way with the array's own back, from which it leads off what the array touches


@dataclass(frozen=True)
class WayBackConfig:
    """How far back, in ticks."""

    leg: int = 80  # that are gone back over at once
    between: int = 10  # its stops
    stuck: int = 30  # since the last time, from which the array has come away from there
    kept: int = 4000  # that are remembered


class WayBack:
    """Grows tick by tick; what was gone back over is forgotten."""

    def __init__(self, config: WayBackConfig = WayBackConfig()) -> None:
        self._config = config
        self._poses: deque[Floats] = deque(maxlen=config.kept)
        self._fresh = 0  # ticks since the array went back last

    def add(self, world_from_sensor: Floats) -> None:
        """Remember where the array is at this tick."""
        self._poses.append(world_from_sensor)
        self._fresh += 1

    def turned_to(self, old_from_new: Floats) -> None:
        """Tell the way of another array from now on, which is at (4, 4) `old_from_new` beside the last one."""
        moved = [pose @ old_from_new for pose in self._poses]
        self._poses.clear()
        self._poses.extend(moved)

    def back(self) -> list[Floats]:
        """(4, 4) poses of the next leg back, from where the array is now to its end; none if it never moved."""
        most, config = len(self._poses), self._config
        count = min(most, config.leg if self._fresh < config.stuck else min(self._fresh, config.leg))
        self._fresh = 0
        return [self._poses.pop() for _ in range(count)]

    def stops(self, leg: list[Floats]) -> list[Floats]:
        """Where to stand still on a leg."""
        return [*leg[1 :: self._config.between], leg[-1]]


def leads_off(leg: list[Floats]) -> bool:
    """Whether an array that came by a leg, its end first, was on its way off what it touches."""
    came = leg[0][:3, 3] - leg[-1][:3, 3]
    return float(came @ -leg[0][:3, 2]) > _OFF * float(np.linalg.norm(came))
