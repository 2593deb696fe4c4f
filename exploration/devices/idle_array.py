"""An array on the stage that is not in use: a body, from skin to the housing's back, which must meet nothing."""

from dataclasses import replace

from exploration.devices.free_space_bound import FreeSpaceBound
from exploration.devices.protocols import StageEvent, StageLimits
from exploration.sensing.physics.housing import HousingWatch
from exploration.sensing.spec import SensorSpec, whole_body
from primitives.arrays import Floats
from primitives.surface import Surface


class IdleArray:
    """One body over one surface."""

    def __init__(
        self, surface: Surface, spec: SensorSpec, flange_from_sensor: Floats, limits: StageLimits
    ) -> None:
        body = replace(spec, housing=whole_body(spec))
        self._name, self._mount = spec.name, flange_from_sensor
        self._far = FreeSpaceBound(surface, body, limits)
        self._watch = HousingWatch(surface, body)

    def met(self, world_from_flange: Floats, time: float) -> StageEvent | None:
        """A collision at `time` [s], where there is one."""
        here = world_from_flange @ self._mount
        if self._far.holds(here):
            return None
        overlap = self._watch.overlap(here)
        return StageEvent("collision", time, overlap, self._name) if overlap > 0.0 else None
