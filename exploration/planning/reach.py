"""The pad among what it has touched so far: whether it has room at a place, and touching there by a free way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from exploration.control.procedures.approach import retreat, touched
from exploration.planning.pad import Pad
from exploration.planning.routes import Tool, route
from exploration.planning.surface_map import SurfaceMap
from primitives import pose as se3
from primitives.arrays import Floats


@dataclass(frozen=True)
class ReachConfig:
    """How a place is come at."""

    standoff: float = 10.0  # [mm] before the last, guarded advance
    overtravel: float = 8.0  # [mm]
    back: float = 4.0  # [mm] from what was met on the way
    room: float = 0.6  # [mm] round the housing, where the pad is to lie
    alike: float = 0.85  # cosine from which two ways out are one


class Reach:
    """Where the pad has room; `led` says whether there was a way to the last target."""

    def __init__(self, pad: Pad, tool: Tool, config: ReachConfig = ReachConfig()) -> None:
        self.pad, self.tool, self.config = pad, tool, config
        self.led = False
        self._felt, self._taken = SurfaceMap(), 0

    @property
    def felt(self) -> SurfaceMap:
        """All that was touched until now."""
        for points, facing in self.pad.felt[self._taken :]:
            self._felt.add(points, facing)
        self._taken = len(self.pad.felt)
        return self._felt

    def clear(self, pose: Floats) -> bool:
        """Whether nothing touched is in the way of the pad and its housing at a (4, 4) pose."""
        return bool(self.tool.clear(pose[None], self._obstacles(), self.config.room, -1.0)[0])

    def touch(self, target: Floats) -> bool:
        """Go round what is known to before a (4, 4) target, and touch it."""
        self.led = False
        standoff = target @ se3.pose(translation=[0.0, 0.0, -self.config.standoff])
        obstacles, guard = self._obstacles(), self.pad.guard
        if not self.clear(target) or not self.tool.clear(standoff[None], obstacles, 1.0, 1.0)[0]:
            return False
        poses = route(self.tool, guard.world_from_sensor, standoff, obstacles, self._ways())
        if poses is None:
            return False
        self.led = True
        for k, pose in enumerate(poses):
            if guard.go_to(pose, until=None if k == 0 else lambda seen: touched(seen.image)) is not None:
                retreat(guard, self.config.back)
                return False
        return self.pad.touch(target, self.config.standoff, self.config.overtravel)

    def _obstacles(self) -> Floats:
        """(n, 3) places of all that is known to stand."""
        told = self.pad.told
        return self.felt.points if told is None else np.concatenate([self.felt.points, told.points])

    def _ways(self) -> Floats:
        """(n, 3) directions that may lead out: the way that each face looks."""
        out: list[Floats] = []
        facing = self.felt.facing
        for normal in [*facing[:: max(1, len(facing) // 200)], *np.eye(3), *-np.eye(3)]:
            if all(normal @ other < self.config.alike for other in out):
                out.append(normal)
        return np.array(out)
