"""The guard: every tick of every controller passes through it.

It turns sensor-frame twists into stage commands, keeps force, indentation and travel below their limits,
counts what exploration costs, and shows each observation to whoever records or watches.  Who learns from frames
is shown none that passed a limit: of a skin that is crushed, taxels may look untouched that are not.  Controllers
see `Observation`s and nothing else of the devices.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numba
import numpy as np

from exploration.devices.following import Following
from exploration.devices.pending import Pending
from exploration.devices.protocols import MotionStage, StageEvent, TactileSensor
from exploration.devices.way_back import WayBack, leads_off
from exploration.sensing.calibration import Calibration, correct
from exploration.sensing.frame import TactileImage, TaxelFrame
from exploration.sensing.load import Load, load_of
from primitives import pose as se3
from primitives.arrays import Floats
from primitives.errors import PalpateError
from primitives.evidence import Contacts
from primitives.pose import apart

_STALE = 0.1  # [s] without a frame, in which a stage of itself ends what it was told


@dataclass(frozen=True)
class GuardLimits:
    """Beyond these the guard stops the stage, whatever the controller asked for."""

    force: float = 60.0  # [N]
    depth: float = 1.6  # [mm] greatest indentation of any taxel, as a mean over its neighborhood
    reach: tuple[float, ...] = (
        -600.0,
        -600.0,
        -600.0,
        600.0,
        600.0,
        600.0,
    )  # [mm] box of the sensor's origin


@dataclass(frozen=True)
class Observation:
    """One tick as a controller sees it."""

    time: float  # [s]
    frame: TaxelFrame
    image: TactileImage
    world_from_sensor: Floats  # (4, 4)
    load: Load
    sensor: int  # index of the array on the stage

    @property
    def force(self) -> float:
        """[N] sum over the taxels, along the sensor's -z."""
        return self.load.force


@dataclass
class Cost:
    """What exploration has cost so far; always reported together."""

    touches: int = 0
    strokes: int = 0
    frames: int = 0
    travel: float = 0.0  # [mm] of the sensor's origin
    seconds: float = 0.0  # [s] on the device's clock


class Fault(PalpateError):
    """A limit was passed; the stage has been stopped and backed off."""

    def __init__(self, message: str, seen: Observation | None = None, came: Sequence[Floats] = ()) -> None:
        super().__init__(message)
        self.seen = seen  # what was felt at that moment
        self.came = came  # (4, 4) world_from_sensor where the array had been just before, the last first
        self.kept = Contacts.of([])  # of the stroke that it ended


class OverPress(Fault):
    """Force or indentation went beyond its limit."""


class Collision(Fault):
    """Something other than the skin touched the object."""


class Guard:
    """One array on one stage, kept within limits."""

    def __init__(
        self,
        stage: MotionStage,
        sensors: Sequence[TactileSensor],
        calibrations: Sequence[Calibration],
        limits: GuardLimits = GuardLimits(),
        observers: Sequence[Callable[[Observation], None]] = (),
    ) -> None:
        self.stage = stage
        self.sensors = tuple(sensors)
        self.calibrations = tuple(calibrations)
        self.limits = limits
        self.observers = tuple(observers)
        self.learners: tuple[Callable[[Observation], None], ...] = ()  # shown what passed every limit only
        self.active = 0
        self.cost = Cost()
        self.pending = Pending(0.0)
        self._last: Observation | None = None
        self._following = Following()
        self._way_back = WayBack()

    @property
    def sensor(self) -> TactileSensor:
        """The array in use."""
        return self.sensors[self.active]

    @property
    def period(self) -> float:
        """Seconds a tick."""
        return self.sensor.period

    @property
    def world_from_sensor(self) -> Floats:
        """(4, 4) where the array in use is now."""
        return self.stage.pose() @ self.sensor.flange_from_sensor

    def move(self, twist: Floats) -> Observation:
        """Follow a (6,) sensor-frame twist (v [mm/s], w [rad/s]) for one tick."""
        if self._last is not None:
            self.pending.say(self._last.time, twist)
            where = self._last.world_from_sensor
            if self.stage.held:
                self._following.rest()
            elif self._following.stands(where, twist, self.period, self.pending.latency):
                self.stage.stop()
                raise Fault(
                    "the stage stands still though told to move; check its reach and drives", self._last
                )
        self.stage.move(_flange_twist(twist, self.sensor.flange_from_sensor))
        return self.observe()

    def use(self, sensor: int) -> None:
        """Work with another of the arrays on the stage, which stands still meanwhile."""
        if sensor != self.active:
            old = self.sensor.flange_from_sensor
            self.active = sensor
            self._way_back.turned_to(se3.inverse(old) @ self.sensor.flange_from_sensor)
            self._following.rest()
            self._last = None

    def hold(self, ticks: int = 1) -> Observation:
        """Stand still for some ticks, at least one."""
        seen = self.move(np.zeros(6))
        for _ in range(ticks - 1):
            seen = self.move(np.zeros(6))
        return seen

    def go_to(
        self, world_from_sensor: Floats, until: Callable[[Observation], bool] | None = None
    ) -> Observation | None:
        """Move straight to a pose; the observation that met `until`, or None once arrived."""
        self._following.rest()
        self.stage.go_to(world_from_sensor @ se3.inverse(self.sensor.flange_from_sensor))
        while self.stage.moving:
            seen = self.observe()
            if until is not None and until(seen):
                self.stage.stop()
                return seen
        return None

    def observe(self) -> Observation:
        """Read the next frame, count its cost, show it around, and enforce the limits."""
        seen = self._read()
        self._way_back.add(seen.world_from_sensor)
        self._enforce(seen)
        for learner in self.learners:
            learner(seen)
        return seen

    def _read(self) -> Observation:
        """The next frame, counted and shown around; no limit is looked at."""
        frame = self.sensor.read()
        image = correct(frame, self.calibrations[self.active], self.sensor.array)
        seen = Observation(frame.time, frame, image, self.world_from_sensor, load_of(image), self.active)
        self._count(seen)
        for observer in self.observers:
            observer(seen)
        return seen

    def _count(self, seen: Observation) -> None:
        self.cost.frames += 1
        if self._last is not None:
            self.cost.travel += apart(seen.world_from_sensor, self._last.world_from_sensor)
            passed = seen.time - self._last.time
            self.cost.seconds += passed
            if passed > _STALE:
                self._following.rest()
        self._last = seen

    def _enforce(self, seen: Observation) -> None:
        alarms = self.stage.events()
        if alarms:
            came = self._back_off()
            kind = Collision if alarms[0].kind == "collision" else OverPress
            by = f" by {alarms[0].amount:.2f} mm" if alarms[0].amount else ""
            raise kind(f"{alarms[0].kind} of {alarms[0].source}{by}", seen, came)
        if seen.load.force > self.limits.force or seen.load.peak > self.limits.depth:
            pressed = f"pressed to {seen.load.force:.1f} N, {seen.load.peak:.2f} mm"
            came = self._back_off()
            raise OverPress(f"{pressed}; lower the press or the speed", seen, came)
        x, y, z = seen.world_from_sensor[:3, 3].tolist()
        left, front, bottom, right, back, top = self.limits.reach
        if not (left <= x <= right and front <= y <= back and bottom <= z <= top):
            self.stage.stop()
            at = [round(x, 1), round(y, 1), round(z, 1)]
            raise PalpateError(f"the stage would leave its travel at {at} mm; widen reach")

    def _back_off(self, distance: float = 5.0) -> list[Floats]:
        """Back along the way that the array came, which was free, and then off the surface if there is room.

        Returns the (4, 4) poses of that way, where the array was stopped first.

        An array that was on its way off the surface has met something behind it, and stays in front of that.
        """
        self.stage.stop()
        self._following.rest()
        if leg := self._way_back.back():
            for here in self._way_back.stops(leg):
                self._back_to(here, through=True)
            lift = se3.pose(translation=[0.0, 0.0, -distance])
            if not leads_off(leg) and not self._back_to(leg[-1] @ lift):
                self._back_to(leg[-1], through=True)
        return leg

    def _back_to(self, world_from_sensor: Floats, through: bool = False) -> bool:
        """Straight back, no farther than a housing meets something, unless `through` that; false where it did.

        The skin may press on, on its way back: let the next leg of it be gone.
        """
        self.stage.go_to(world_from_sensor @ se3.inverse(self.sensor.flange_from_sensor))
        alarms: list[StageEvent] = []
        while self.stage.moving and (through or not _collided(alarms)):
            self._read()
            alarms += self.stage.events()
        alarms += self.stage.events()
        if alarms:
            self.stage.stop()
        return not _collided(alarms)


def _collided(alarms: Sequence[StageEvent]) -> bool:
    return any(alarm.kind == "collision" for alarm in alarms)


@numba.njit(cache=True, error_model="numpy")
def _flange_twist(twist: Floats, flange_from_sensor: Floats) -> Floats:
    """The same motion seen from the flange: w turns with the frame, v gains the lever arm's part."""
    out = np.zeros(6)
    for i in range(3):
        for j in range(3):
            out[i] += flange_from_sensor[i, j] * twist[j]
            out[3 + i] += flange_from_sensor[i, j] * twist[3 + j]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[i] += flange_from_sensor[j, 3] * out[3 + k] - flange_from_sensor[k, 3] * out[3 + j]
    return out
