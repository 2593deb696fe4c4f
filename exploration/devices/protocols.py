"""The two protocols that simulator, recording and hardware share.

Time passes while a frame is read: `read` returns when the array's next frame is complete, and the stage
moves meanwhile as it was last told.  A control loop is ``frame = sensor.read(); stage.move(law(frame))``.
"""

from dataclasses import dataclass
from math import hypot, isfinite
from typing import Protocol

import numpy as np

from exploration.sensing.frame import TaxelArray, TaxelFrame
from primitives.arrays import Floats
from primitives.errors import PalpateError


@dataclass(frozen=True)
class StageLimits:
    """What a stage can do; every controller stays below it."""

    speed: float = 150.0  # [mm/s]
    acceleration: float = 2000.0  # [mm/s^2]
    turn_speed: float = 2.0  # [rad/s]
    turn_acceleration: float = 30.0  # [rad/s^2]

    def shortened(self, twist: Floats) -> Floats:
        """A (6,) twist no faster than the speeds allow."""
        x, y, z, a, b, c = map(float, twist)
        linear = self.speed / max(hypot(x, y, z), self.speed)
        turning = self.turn_speed / max(hypot(a, b, c), self.turn_speed)
        return np.array([linear * x, linear * y, linear * z, turning * a, turning * b, turning * c])


def checked_twist(twist: Floats) -> Floats:
    """(6,) finite numbers, as every stage demands them."""
    wanted = np.array(twist, dtype=float)
    if wanted.shape != (6,) or not all(map(isfinite, wanted.tolist())):
        raise PalpateError(f"a twist is six finite numbers (mm/s, rad/s), not {twist!r}")
    return wanted


@dataclass(frozen=True)
class StageEvent:
    """Something that must not happen, as the stage's drives notice it."""

    kind: str  # "collision" of a housing, "overpress" of a skin, or a drive's own alarm
    time: float  # [s] on the device's clock
    amount: float  # [mm] overlap, or indentation beyond the skin's thickness
    source: str  # the array or axis concerned


class TactileSensor(Protocol):
    """A tactile array on a stage."""

    @property
    def array(self) -> TaxelArray:
        """Its layout."""
        ...

    @property
    def flange_from_sensor(self) -> Floats:
        """(4, 4) where it is mounted."""
        ...

    @property
    def period(self) -> float:
        """Seconds from one frame to the next."""
        ...

    def read(self) -> TaxelFrame:
        """The next frame; raises `PalpateError` when none comes."""
        ...


class MotionStage(Protocol):
    """Something that moves an array about.

    A class of one's own that names it as its base is never held and tells of no events.
    """

    @property
    def limits(self) -> StageLimits:
        """What it can do."""
        ...

    def pose(self) -> Floats:
        """(4, 4) world_from_flange, where it is now, as its own encoders say."""
        ...

    def move(self, twist: Floats) -> None:
        """Follow a (6,) twist (v [mm/s], w [rad/s]) in the flange frame until told otherwise."""
        ...

    def go_to(self, world_from_flange: Floats) -> None:
        """Start a straight move to a pose at the stage's limits; `moving` tells when it has ended."""
        ...

    @property
    def moving(self) -> bool:
        """Whether a `go_to` is under way."""
        ...

    def stop(self) -> None:
        """Come to rest at the acceleration limit."""
        ...

    @property
    def held(self) -> bool:
        """Whether a watchdog or a person holds it, so that it follows no twist for now."""
        return False

    def events(self) -> tuple[StageEvent, ...]:
        """What its drives have noticed since last asked; empty when all is well."""
        return ()
