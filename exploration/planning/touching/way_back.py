"""Ways back where the stage has come from, for the array that is in use now."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from exploration.control.procedures.approach import touched
from exploration.devices.guard import Guard, Observation
from exploration.planning.known.trail import Trail
from primitives import pose as se3
from primitives.arrays import Floats

_LIFT = 3.0  # [mm] off what the skin touched: the stage comes back faster than it pressed


class WayBack:
    """The trail of what a guard carries; every stop is a (4, 4) pose of its array in use."""

    def __init__(self, guard: Guard) -> None:
        self._guard, self._trail = guard, Trail()

    def note(self, seen: Observation) -> None:
        """Note where the stage is."""
        off = se3.inverse(self._guard.sensor.flange_from_sensor)
        if self._trail.leaves(seen.world_from_sensor @ off):
            lift = se3.pose(translation=[0.0, 0.0, -_LIFT if touched(seen.image) else 0.0])
            self._trail.pass_through(seen.world_from_sensor @ lift @ off)

    @property
    def length(self) -> int:
        """Of the trail, to come back `since` then."""
        return self._trail.length

    @property
    def start(self) -> Floats | None:
        """Where it began; None where nothing was noted yet."""
        start = self._trail.start
        return None if start is None else start @ self._guard.sensor.flange_from_sensor

    def ways(self) -> Iterator[list[Floats]]:
        """The stops of ever longer ways back."""
        self._rejoin()
        return (self._stops(poses) for poses in self._trail.back())

    def since(self, length: int) -> list[Floats]:
        """The stops of the way back to where the trail had a length."""
        self._rejoin()
        return self._stops(self._trail.since(length))

    def _rejoin(self) -> None:
        here = self._guard.world_from_sensor
        self._trail.rejoin(here @ se3.inverse(self._guard.sensor.flange_from_sensor))

    def _stops(self, poses: Sequence[Floats]) -> list[Floats]:
        return [pose @ self._guard.sensor.flange_from_sensor for pose in poses]
