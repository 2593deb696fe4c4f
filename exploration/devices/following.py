"""Whether a stage does what it is told: a drive at its end, or one that lost its steps, stands still in silence.

Commands are added up, as are the places that the encoders tell.  Once more than `least` has been asked for, beside
what is still on its way, at least a share of it must have been gone, along it; then the count begins anew.
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

    def rest(self) -> None:
        """The stage goes by itself now."""
        self._from = None

    def stands(self, world_from_sensor: Floats, twist: Floats, period: float, latency: float) -> bool:
        """Whether the stage stood still though told to move; now it is told a (6,) sensor twist for a period."""
        if self._from is None:
            self._from, self._asked = world_from_sensor[:3, 3], np.zeros(3)
        self._asked = self._asked + world_from_sensor[:3, :3] @ twist[:3] * period
        asked = float(np.linalg.norm(self._asked))
        if asked < LEAST + float(np.linalg.norm(twist[:3])) * (latency + SLACK):
            return False
        gone = float((world_from_sensor[:3, 3] - self._from) @ self._asked) / asked
        self._from = None
        return gone < SHARE * asked
