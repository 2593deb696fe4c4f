"""Whether a stage does what it is told: a drive at its end, or one that lost its steps, stands still in silence.

Commands are added up.  Once more than `LEAST` has been asked for, beside what is still on its way, the encoders
must have told of a place at least a share of that away, in any direction: a stroke that turns round within the
count is no stage that stands.  Then the count begins anew.
"""

import numba
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
        away, asked, speed = _counted(world_from_sensor, twist, period, self._from, self._asked)
        self._farthest = max(self._farthest, away)
        if asked < LEAST + speed * (latency + SLACK):
            return False
        self._from = None
        return bool(self._farthest < SHARE * asked)


@numba.njit(cache=True, error_model="numpy")
def _counted(
    pose: Floats, twist: Floats, period: float, start: Floats, asked: Floats
) -> tuple[float, float, float]:
    """How far a (4, 4) pose is from the start, how far was asked for, this twist added in place, and its speed."""
    away = far = speed = 0.0
    for i in range(3):
        for j in range(3):
            asked[i] += pose[i, j] * twist[j] * period
        away += (pose[i, 3] - start[i]) ** 2
        far += asked[i] ** 2
        speed += twist[i] ** 2
    return np.sqrt(away), np.sqrt(far), np.sqrt(speed)
