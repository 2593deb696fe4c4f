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

A limit that stops motion once it is passed is passed.  So what a touching pad feels is judged as it will be when
all that was sent has been done, whoever may die meanwhile, F + k A (d + v t) with d the way toward the object that
is still to come and t the time until the stage's thread has seen the frame; and toward the object the pad goes no
faster than it may run blind into a flat, k A (v (s + t + h) + v^2 / (2 a)) <= F with s the silence after which it
is stopped and h the time for which motion is sent (our derivation; both with the skin as a Winkler foundation of
stiffness k and area A).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from exploration.devices.clock import MACHINE, Clock
from exploration.devices.protocols import StageEvent
from exploration.sensing.calibration import Calibration
from exploration.sensing.frame import TaxelFrame
from primitives.arrays import Floats

_TOUCH = 0.02  # of the force limit, from which something is touched
_ROUNDING = 1.0 / 12.0  # [counts^2] variance, which a calibration's noise holds


@dataclass(frozen=True)
class SafetyLimits:
    """Beyond these motion stops."""

    force: float = 60.0  # [N] over the whole pad
    reach: tuple[float, ...] = (-1e9, -1e9, -1e9, 1e9, 1e9, 1e9)  # [mm] box of the flange
    patience: float = 0.02  # [s] past one and a half periods without a frame, until the stage is held
    lead: float = 0.01  # [s] from a frame until the stage's thread has judged it
    ahead: float = 0.025  # [s] for which motion is sent ahead, while the stage does not tell
    margin: float = 1.05  # of the force at a stop, that the way back may show before it is stopped, too
    chance: float = 1e-9  # of repeated frames by noise alone, below which the array is frozen
    frozen: float = 0.2  # [s] of it, after which reading on is in vain: no cable repeats frames by itself


class Safety:
    """One array's and one stage's limits."""

    def __init__(
        self,
        calibration: Calibration,
        area: float,
        period: float,
        limits: SafetyLimits,
        flange_from_sensor: Floats | None = None,
        clock: Clock = MACHINE,
    ) -> None:
        self._calibration, self._area, self.limits, self._clock = calibration, area, limits, clock
        self._mount = np.eye(4) if flange_from_sensor is None else flange_from_sensor
        way, arm = self._mount[:3, 2], self._mount[:3, 3]
        self._onward = np.concatenate(
            [way, np.cross(arm, way)]
        )  # of a (6,) twist, what goes toward the object
        self._silence = 1.5 * period + limits.patience
        self._heard = clock.now()
        self._ceiling = limits.force
        self._force, self._toward = 0.0, 0.0  # [N], [mm/s] as it was asked last
        self._skin = _skin(calibration, area)  # the whole skin's area over that of the taxels
        self._stiffness = self._skin * calibration.stiffness * area * calibration.zero.size  # [N/mm]
        self._leads_to: Floats | None = (
            None  # (4, 4) where all that was sent leads; None where no stage tells
        )
        self.where: Callable[[float], Floats] = lambda moment: np.eye(
            4
        )  # the flange then, as the stage tells
        self._told = False
        self._counts = np.empty(0)
        self._repeats = 0.0  # log of the chance that noise repeats a frame so often
        sigma = float(np.sqrt(max(calibration.noise**2 - _ROUNDING, 0.0)))
        self._again = min(0.0, float(-np.log(max(2.0 * np.sqrt(np.pi) * sigma, 1.0))))
        self.tripped = ""  # why; empty while all is well
        self.most = 0.0  # [N] that any frame showed
        self.holds = 0

    def seen(self, frame: TaxelFrame) -> None:
        """A frame, from the array's thread."""
        if not self._repeated(frame.counts):
            self._heard = self._clock.now()
        self._force = force = self.force(frame)
        self.most = max(self.most, force)
        if force < self.limits.force:
            self._ceiling = self.limits.force
        if force > _TOUCH * self.limits.force:
            force += self._stiffness * (self._coming(frame.time) + self._toward * self.limits.lead)
        if force > self._ceiling and not self.tripped:
            self.tripped = f"{force:.0f} N would be more than the limit of {self.limits.force:.0f} N"

    def sent(self, here: Floats, leads_to: Floats) -> None:
        """(4, 4) where the flange is and where all that was sent leads, from the stage's thread."""
        self.at(here[:3, 3])
        self._leads_to = leads_to

    def _coming(self, moment: float) -> float:
        """[mm] toward the object that were sent and, at the moment of a frame, not done."""
        if self._leads_to is None:
            return self._toward * self.limits.ahead
        before, after = self.where(moment) @ self._mount, self._leads_to @ self._mount
        return max(0.0, float(before[:3, 2] @ (after[:3, 3] - before[:3, 3])))

    def force(self, frame: TaxelFrame) -> float:
        """[N] over the whole pad, its skin past the outer taxels pressed alike."""
        c = self._calibration
        return float(self._skin * self._area * ((frame.counts - c.zero) / c.gain)[~c.dead].sum())

    def shortened(self, twist: Floats, acceleration: float) -> Floats:
        """A (6,) flange twist that presses the pad on no faster than it may run blind into a flat."""
        toward = float(self._onward @ twist)
        depth = self.limits.force / self._stiffness
        late = self._silence + self.limits.lead + self.limits.ahead
        blind = acceleration * (np.sqrt(late**2 + 2.0 * depth / acceleration) - late)
        self._toward = max(0.0, min(toward, blind))
        return np.asarray(twist * min(1.0, blind / max(toward, 1e-9)))

    def goes(self) -> None:
        """No twist is wished for any more: what is to come is what was sent."""
        self._toward = 0.0

    def lost(self) -> None:
        """The array's port has gone: no patience is owed."""
        self._heard = -np.inf

    def silent(self, now: float) -> bool:
        """Whether frames have stopped, or show nothing new."""
        return now - self._heard > self._silence

    @property
    def frozen(self) -> str:
        """Why reading on is in vain; empty while frames show news."""
        if self._repeats > np.log(self.limits.chance):
            return ""
        seconds = self._clock.now() - self._heard if np.isfinite(self._heard) else 0.0
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

    def untold(self) -> tuple[StageEvent, ...]:
        """What tripped, the first time that the loop asks."""
        if not self.tripped or self._told:
            return ()
        self._told = True
        return (StageEvent("overpress", self._clock.now(), 0.0, f"a limit ({self.tripped})"),)

    def answered(self) -> None:
        """The control loop has heard: a way back is allowed, as long as the force does not grow on it."""
        self._ceiling = max(self.limits.force, self.limits.margin * self._force)
        self.tripped, self._told = "", False


def _skin(calibration: Calibration, area: float) -> float:
    """The whole skin's area over that of its taxels, which feel nothing of its margin."""
    margin = calibration.margin if np.isfinite(calibration.margin) else 0.0
    sides = np.array(calibration.zero.shape) * np.sqrt(area)
    return float(np.prod(sides + 2.0 * margin) / np.prod(sides))
