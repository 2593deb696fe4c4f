"""Whether a stage does what it is told: a drive at its end, or one that lost its steps, stands still in silence.

Commands are added up.  Once more than `LEAST` has been asked for, beside what is still on its way, the encoders
must have told of a place at least a share of that away, in any direction: a stroke that turns round within the
count is no stage that stands.  Then the count begins anew.
"""

import numpy as np

from primitives.arrays import Floats

LEAST = 5.0  # [mm]
SHARE = 0.05
SLACK = 0.1  # [s] of motion that a stage may be late, beside its latency


class Following:
    """One stage's motion under twists."""

    def __init__(self) -> None:
        self._from: Floats | None = None  # (3,) [mm] where the count began
        self._asked = np.zeros(3)  # [mm] since then, in the world
        self._farthest = 0.0  # [mm] from there, since then

    def rest(self) -> None:
        """The stage goes by itself now."""
        self._from = None

    def stands(self, world_from_sensor: Floats, twist: Floats, period: float, latency: float) -> bool:
        """Whether the stage stood still though told to move; now it is told a (6,) sensor twist for a period."""
        if self._from is None:
            self._from, self._asked, self._farthest = world_from_sensor[:3, 3], np.zeros(3), 0.0
        away = float(np.linalg.norm(world_from_sensor[:3, 3] - self._from))
        self._farthest = max(self._farthest, away)
        self._asked = self._asked + world_from_sensor[:3, :3] @ twist[:3] * period
        asked = float(np.linalg.norm(self._asked))
        if asked < LEAST + float(np.linalg.norm(twist[:3])) * (latency + SLACK):
            return False
        self._from = None
        return self._farthest < SHARE * asked
