"""Holes too narrow for any taxel to be free over them, as frame after frame shows them.

A pit that stays with the object while the pad moves is one of the object; one that stays with the pad is a deaf
taxel, and one that is never seen again is noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from exploration.devices.guard import Observation
from exploration.sensing.lines.pits import pits
from primitives import pose as se3
from primitives.arrays import Floats


@dataclass(frozen=True)
class SeenPitsConfig:
    """When two sightings are of one."""

    beside: float = 1.5  # [mm] between them on the object
    facing: float = 0.97  # least cosine between the ways that they look
    moved: float = 2.5  # [mm] between them on the pad
    times: int = 3  # seen


@dataclass(frozen=True)
class SeenPit:
    """One place, and how often it was seen."""

    center: Floats  # (3,) [mm], the mean of its sightings
    normal: Floats  # (3,) out of the object
    radius: float  # [mm]
    first: Floats  # (2,) [mm] on the pad, where it was seen first
    times: int = 1
    moved: float = 0.0  # [mm] on the pad since


class SeenPits:
    """Grows with every look."""

    def __init__(self, config: SeenPitsConfig | None = None) -> None:
        self.config = config or SeenPitsConfig()
        self._all: list[SeenPit] = []

    def look(self, seen: Observation) -> None:
        """Remember the pits of a frame."""
        pose = seen.world_from_sensor
        for pit in pits(seen.image):
            local = np.array([[*pit.center, -pit.depth]])
            self._note(SeenPit(se3.transform_points(pose, local)[0], -pose[:3, 2], pit.radius, pit.center))

    def _note(self, new: SeenPit) -> None:
        for k, old in enumerate(self._all):
            near = float(np.linalg.norm(old.center - new.center)) < self.config.beside
            if near and float(old.normal @ new.normal) > self.config.facing:
                share = 1.0 / (old.times + 1)
                self._all[k] = replace(
                    old,
                    center=old.center + share * (new.center - old.center),
                    radius=old.radius + share * (new.radius - old.radius),
                    times=old.times + 1,
                    moved=max(old.moved, float(np.linalg.norm(new.first - old.first))),
                )
                return
        self._all.append(new)

    @property
    def sure(self) -> Sequence[SeenPit]:
        """Those that stayed with the object."""
        return [pit for pit in self._all if pit.times >= self.config.times and pit.moved > self.config.moved]
