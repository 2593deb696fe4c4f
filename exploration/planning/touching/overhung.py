"""Which stops of strokes were the housing's, and not the skin's side: it came to what was felt before.

What was felt is only ever added to, so each stop is held beside each felt place once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from exploration.planning.known.surface_map import SurfaceMap
from exploration.planning.touching.study import Wall
from exploration.planning.ways.routes import Tool
from primitives.arrays import Floats


@dataclass(frozen=True)
class OverhungConfig:
    """Where the housing may have come to something."""

    came: float = 2.0  # [mm] from the housing, within which it came to something
    room: float = 0.6  # [mm] beside it
    skin: float = 4.0  # [mm] from the skin, within which its side may have come to something as well
    faced: float = 0.9  # cosine from which it was felt to face the way of the stroke


class Overhung:
    """Remembers of every stop what was looked at."""

    def __init__(self, config: OverhungConfig = OverhungConfig()) -> None:
        self._config = config
        self._known: dict[
            int, tuple[Wall, int, bool]
        ] = {}  # by identity: how many places, and whether one was

    def holds(self, wall: Wall, felt: SurfaceMap, tool: Tool) -> bool:
        """Whether a housing that was stopped had come to a felt place."""
        _, count, found = self._known.get(id(wall), (wall, 0, False))
        if not found and count < len(felt.points):
            found = self._among(wall, felt.points[count:], felt.facing[count:], tool)
        self._known[id(wall)] = wall, len(felt.points), found
        return found

    def _among(self, wall: Wall, points: Floats, facing: Floats, tool: Tool) -> bool:
        turn = wall.pose[:3, :3]
        local, way = (points - wall.pose[:3, 3]) @ turn, turn.T @ wall.heading
        ahead = local - np.outer((local @ way > 0.0) * self._config.came, way)
        within = (np.abs(ahead[:, :2]) < wall.half + self._config.room).all(axis=1)
        behind = (local[:, 2] > tool.low[2]) & (local[:, 2] < -self._config.skin)
        return bool((within & behind & (facing @ wall.heading < -self._config.faced)).any())
