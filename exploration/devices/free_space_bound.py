"""Cheap proof that no part of a sensor can touch: its ball has not moved as far as it was free.

The signed distance of the ball's center changes by no more than the center moves, so it is asked again only when
the center has moved by as much as the last answer allows.
"""

from math import dist

import numpy as np

from exploration.devices.protocols import StageLimits
from exploration.sensing.physics.housing import housing_box
from exploration.sensing.physics.skin import skin_of
from exploration.sensing.spec import SensorSpec
from primitives.arrays import Floats
from primitives.surface import Surface


class FreeSpaceBound:
    """One sensor's ball, skin and housing in it, over one surface."""

    def __init__(self, surface: Surface, spec: SensorSpec, limits: StageLimits) -> None:
        self._surface = surface
        skin, (low, _) = skin_of(spec), housing_box(spec)
        half = [max(skin.x_edges[-1], -low[0]), max(skin.y_edges[-1], -low[1]), -low[2] / 2]
        scan = spec.electronics.scan
        radius = float(np.linalg.norm(half))
        self._depth = float(low[2] / 2)
        self._radius = radius + scan * (limits.speed + limits.turn_speed * 2 * radius)
        self._center: tuple[float, float, float] | None = None
        self._free = 0.0  # [mm] the ball's own clearance where it was asked for; negative near the surface

    def holds(self, world_from_sensor: Floats) -> bool:
        """Whether the whole sensor is provably off the surface."""
        (_, _, ax, x), (_, _, ay, y), (_, _, az, z), _ = world_from_sensor.tolist()
        x, y, z = x + self._depth * ax, y + self._depth * ay, z + self._depth * az
        if self._center is None or dist((x, y, z), self._center) >= abs(self._free):
            self._center = (x, y, z)
            self._free = float(self._surface.signed_distance(np.array([[x, y, z]]))[0]) - self._radius
        return self._free > 0.0
