"""What stops a stage whatever the control loop does: force and travel limits, and a watchdog on the frames.

`Safety` is fed by the array's own thread and asked by the stage's own thread, a few hundred times a
second; neither waits for the control loop.  Three answers: go on; hold until frames come again; or
tripped, which ends whatever moves and refuses every motion until `stop` has been heard, so that the next
motion is the loop's way back and not what it did before.
"""

import time
from dataclasses import dataclass

import numpy as np

from exploration.sensing.calibration import Calibration
from exploration.sensing.frame import TaxelFrame
from primitives.arrays import Floats


@dataclass(frozen=True)
class SafetyLimits:
    """Beyond these motion stops."""

    force: float = 60.0  # [N] over the whole pad
    reach: tuple[float, ...] = (-1e9, -1e9, -1e9, 1e9, 1e9, 1e9)  # [mm] box of the flange
    patience: float = 0.03  # [s] past one and a half periods without a frame, until the stage is held
    margin: float = 1.05  # of the force at a stop, that the way back may show before it is stopped, too


class Safety:
    """One array's and one stage's limits."""

    def __init__(self, calibration: Calibration, area: float, period: float, limits: SafetyLimits) -> None:
        self._calibration, self._area, self.limits = calibration, area, limits
        self._silence = 1.5 * period + limits.patience
        self._heard = time.monotonic()
        self._ceiling = limits.force
        self._force = 0.0
        self.tripped = ""  # why; empty while all is well
        self.most = 0.0  # [N] that any frame showed
        self.holds = 0

    def seen(self, frame: TaxelFrame) -> None:
        """A frame, from the array's thread."""
        c = self._calibration
        self._heard = time.monotonic()
        signal = (frame.counts - c.zero) / c.gain
        self._force = float(self._area * signal[~c.dead].sum())
        self.most = max(self.most, self._force)
        if self._force < self.limits.force:
            self._ceiling = self.limits.force
        if self._force > self._ceiling and not self.tripped:
            self.tripped = f"{self._force:.0f} N is more than the limit of {self.limits.force:.0f} N"

    def silent(self, now: float) -> bool:
        """Whether frames have stopped."""
        return now - self._heard > self._silence

    def at(self, flange: Floats) -> None:
        """Where the flange is, from the stage's thread."""
        low, high = np.array(self.limits.reach[:3]), np.array(self.limits.reach[3:])
        if (flange < low).any() or (flange > high).any():
            self.tripped = (
                self.tripped or f"the flange is beyond its limits at {np.round(flange, 1).tolist()} mm"
            )

    def answered(self) -> None:
        """The control loop has heard: a way back is allowed, as long as the force does not grow on it."""
        self._ceiling = max(self.limits.force, self.limits.margin * self._force)
        self.tripped = ""
