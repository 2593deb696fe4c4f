"""What stops a stage whatever the control loop does: force and travel limits, and a watchdog on the frames.

`Safety` is fed by the array's own thread and asked by the stage's own thread, a few hundred times a
second; neither waits for the control loop.  Three answers: go on; hold until frames come again; or
tripped, which ends whatever moves and refuses every motion until `stop` has been heard, so that the next
motion is the loop's way back and not what it did before.

A frame that repeats the one before count by count is news only as long as noise may have done that.  Two
readings of one press with noise s [counts] round to the same count with a chance of at most about
1 / (2 sqrt(pi) s), the chance of a whole frame is the product over the taxels that show more than nothing
and less than all, and that of a run of repeats the product over them (our derivation).  Past `chance`
the array is taken as frozen, which is silence since the last news.
"""

import time
from dataclasses import dataclass

import numpy as np

from exploration.sensing.calibration import Calibration
from exploration.sensing.frame import TaxelFrame
from primitives.arrays import Floats

_ROUNDING = 1.0 / 12.0  # [counts^2] variance, which a calibration's noise holds


@dataclass(frozen=True)
class SafetyLimits:
    """Beyond these motion stops."""

    force: float = 60.0  # [N] over the whole pad
    reach: tuple[float, ...] = (-1e9, -1e9, -1e9, 1e9, 1e9, 1e9)  # [mm] box of the flange
    patience: float = 0.03  # [s] past one and a half periods without a frame, until the stage is held
    margin: float = 1.05  # of the force at a stop, that the way back may show before it is stopped, too
    chance: float = 1e-9  # of repeated frames by noise alone, below which the array is frozen
    frozen: float = 2.0  # [s] of it, after which reading on is in vain


class Safety:
    """One array's and one stage's limits."""

    def __init__(self, calibration: Calibration, area: float, period: float, limits: SafetyLimits) -> None:
        self._calibration, self._area, self.limits = calibration, area, limits
        self._silence = 1.5 * period + limits.patience
        self._heard = time.monotonic()
        self._ceiling = limits.force
        self._force = 0.0
        self._counts = np.empty(0)
        self._repeats = 0.0  # log of the chance that noise repeats a frame so often
        sigma = float(np.sqrt(max(calibration.noise**2 - _ROUNDING, 0.0)))
        self._again = min(0.0, float(-np.log(max(2.0 * np.sqrt(np.pi) * sigma, 1.0))))
        self.tripped = ""  # why; empty while all is well
        self.most = 0.0  # [N] that any frame showed
        self.holds = 0

    def seen(self, frame: TaxelFrame) -> None:
        """A frame, from the array's thread."""
        c = self._calibration
        if not self._repeated(frame.counts):
            self._heard = time.monotonic()
        signal = (frame.counts - c.zero) / c.gain
        self._force = float(self._area * signal[~c.dead].sum())
        self.most = max(self.most, self._force)
        if self._force < self.limits.force:
            self._ceiling = self.limits.force
        if self._force > self._ceiling and not self.tripped:
            self.tripped = f"{self._force:.0f} N is more than the limit of {self.limits.force:.0f} N"

    def silent(self, now: float) -> bool:
        """Whether frames have stopped, or show nothing new."""
        return now - self._heard > self._silence

    @property
    def frozen(self) -> str:
        """Why reading on is in vain; empty while frames show news."""
        if self._repeats > np.log(self.limits.chance):
            return ""
        seconds = time.monotonic() - self._heard
        return "the array repeats one frame; check its power, then begin again" * (
            seconds > self.limits.frozen
        )

    def _repeated(self, counts: Floats) -> bool:
        """Whether the frame is one of a run that noise does not explain."""
        c, before = self._calibration, self._counts
        self._counts = counts
        if not np.array_equal(counts, before):
            self._repeats = 0.0
            return False
        floor = c.zero + c.threshold if c.threshold > 0.0 else 0.0
        telling = (counts > floor) & (counts < c.full_scale) & ~c.dead
        self._repeats += self._again * int(telling.sum())
        return self._repeats < float(np.log(self.limits.chance))

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
