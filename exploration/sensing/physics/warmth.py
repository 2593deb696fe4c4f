"""The skin's thermal layer: dT/dt = (T_object - T) / tau in contact, and ten times slower toward the air without.

One lump of heat capacity behind one resistance (our derivation); the object is large and keeps its temperature.
"""

import numpy as np

from exploration.sensing.spec import Thermal
from primitives.surface import Surface, WarmSurface

_AIR = 10.0  # times the time constant of contact


class Warmth:
    """What the layer remembers."""

    def __init__(self, layer: Thermal, surface: Surface, rng: np.random.Generator) -> None:
        self._layer, self._surface, self._rng = layer, surface, rng
        self._now = layer.ambient

    def felt(self, dt: float, touching: bool) -> float:
        """[deg C] as it is read `dt` [s] after the reading before."""
        layer = self._layer
        target, tau = layer.ambient, layer.time_constant * (1.0 if touching else _AIR)
        if touching and isinstance(self._surface, WarmSurface):
            target = self._surface.temperature
        self._now = target + (self._now - target) * float(np.exp(-dt / tau))
        return self._now + (layer.noise * float(self._rng.standard_normal()) if layer.noise else 0.0)
