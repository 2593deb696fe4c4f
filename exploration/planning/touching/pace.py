"""What touching takes on a device: the one account of seconds, for who plans touches and who counts them.

    seconds = way there + flight / stage's speed + the rest of the advance / its own + settling + way back

A straight move of a path d ends after d / v + v / a, and turning goes on meanwhile.  How long a pad takes to lie,
and to come again where the housing was met first, are means over 190 simulated touches of the LTS-210.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from exploration.control.procedures.approach import felt_speed
from exploration.control.procedures.tare import TareConfig
from exploration.devices.guard import Guard
from exploration.devices.protocols import StageLimits
from exploration.planning.touching.lone_touch import LoneTouchConfig
from exploration.planning.ways.round_ball import length_of
from primitives.arrays import Floats


@dataclass(frozen=True)
class Pace:
    """Of one array on one stage."""

    stage: StageLimits = field(default_factory=StageLimits)
    advance: float = 29.0  # [mm/s] that the pad feels its way with
    ready: float = 0.1  # [s] before an advance, in which its zero is read, and after, in which it is
    settling: float = 0.7  # [s] from the first contact until the pad lies and was read
    failing: float = 3.3  # [s] more, where the housing is met first: back off, lean and come again

    @staticmethod
    def of(guard: Guard) -> Pace:
        """Of the array that it uses now."""
        usual = LoneTouchConfig()
        frames = TareConfig().frames + usual.averaged
        return Pace(guard.stage.limits, felt_speed(guard, usual.speed), frames * guard.period)

    def travel(self, here: Floats, way: Sequence[Floats]) -> float:
        """[s] of straight moves from stop (4, 4) to stop."""
        total, stage = 0.0, self.stage
        for stop in way:
            path, turning = length_of(here, [stop])
            moved = path / stage.speed + stage.speed / stage.acceleration
            turned = turning / stage.turn_speed + stage.turn_speed / stage.turn_acceleration
            total, here = total + max(moved, turned), stop
        return total

    def approach(self, flown: Floats | float, felt: Floats | float) -> Floats:
        """[s] of flying so far [mm], and of feeling so far from there on."""
        begun = np.where(np.asarray(flown) > 0.0, self._ramp, 0.0)
        return np.asarray(begun + flown / self.stage.speed + felt / self.advance + self.ready)

    def back(self, gone: Floats | float) -> Floats:
        """[s] of going straight off what was met, and from there back to where so long an approach [mm] began."""
        return np.asarray(gone / self.stage.speed + 2.0 * self._ramp)

    @property
    def _ramp(self) -> float:
        return self.stage.speed / self.stage.acceleration
