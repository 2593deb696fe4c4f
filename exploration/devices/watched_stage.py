"""A stage of one's own, kept within the same limits as a built-in one: force, travel, a watchdog on the frames.

Its driver need not know of any of them.  A thread looks every few milliseconds, whatever the control loop does: a
force that will pass its limit, or a flange beyond its box, stops the stage and refuses motion until `stop` has
been heard; frames that stay away hold it until they come again; a twist that nobody renews ends.  A driver that
raises ends the run.
"""

import threading
from collections.abc import Callable

import numpy as np

from exploration.devices.clock import MACHINE, Clock
from exploration.devices.protocols import MotionStage, StageEvent, StageLimits, checked_twist
from exploration.devices.safety import Safety
from primitives.arrays import Floats
from primitives.errors import PalpateError

_LOOK = 0.004  # [s] between two looks
_STALE = 0.15  # [s] after which a twist counts as none


class WatchedStage:
    """Another `MotionStage`, watched."""

    def __init__(self, stage: MotionStage, safety: Safety, clock: Clock = MACHINE) -> None:
        self._stage, self._safety, self._clock = stage, safety, clock
        self._lock = threading.RLock()
        self._open = True
        self._twisted = np.inf  # [s] when a twist was wished for last
        self._goal: Floats | None = None
        self._held = False  # for want of frames
        self.fault = ""
        self._thread = threading.Thread(target=self._run, name="stage", daemon=True)

    @property
    def limits(self) -> StageLimits:
        """What it can do."""
        return self._stage.limits

    def start(self) -> None:
        """Begin to watch."""
        self._thread.start()

    def as_of(self, moment: float) -> None:
        """A driver of one's own tells where the stage is now, and no more."""

    def pose(self) -> Floats:
        """(4, 4) world_from_flange."""
        return self._stage.pose()

    def move(self, twist: Floats) -> None:
        """Follow a (6,) twist in the flange frame, unless something stands against it."""
        wanted = self._safety.shortened(self.limits.shortened(checked_twist(twist)), self.limits.acceleration)

        def follow() -> None:
            self._twisted, self._goal = self._clock.now(), None
            self._stage.move(wanted)

        self._unless_stopped(follow)

    def go_to(self, world_from_flange: Floats) -> None:
        """Start a straight move, unless something stands against it."""

        def head() -> None:
            self._twisted, self._goal = np.inf, world_from_flange
            self._stage.go_to(world_from_flange)

        self._unless_stopped(head)

    @property
    def moving(self) -> bool:
        """Whether a `go_to` is under way."""
        with self._lock:
            if self.fault or self._safety.tripped or self._goal is None:
                return False
            return self._held or self._stage.moving

    @property
    def held(self) -> bool:
        """Whether frames stay away."""
        return self._held

    def stop(self) -> None:
        """Come to rest; what tripped has been heard."""
        with self._lock:
            self._twisted, self._goal = np.inf, None
            self._stage.stop()
            self._safety.answered()

    def events(self) -> tuple[StageEvent, ...]:
        """What its drives have noticed."""
        return (*self._stage.events(), *self._safety.untold())

    def close(self) -> None:
        """Stop, and let go of whatever the driver holds."""
        self._open = False
        if self._thread.is_alive():
            self._thread.join(0.5)
        self._stage.stop()
        getattr(self._stage, "close", lambda: None)()

    def _unless_stopped(self, act: Callable[[], None]) -> None:
        if self.fault:
            raise PalpateError(self.fault)
        with self._lock:
            if not self._safety.tripped and not self._safety.silent(self._clock.now()):
                act()

    def _run(self) -> None:
        try:
            while self._open:
                self._look()
                self._clock.sleep(_LOOK)
        except Exception as error:
            self.fault = f"the stage's driver failed ({type(error).__name__}: {error}); motion has stopped"
            self._stage.stop()

    def _look(self) -> None:
        with self._lock:
            now = self._clock.now()
            self._safety.at(self._stage.pose()[:3, 3])
            tripped, silent = bool(self._safety.tripped), self._safety.silent(now)
            if tripped:
                self._goal = None
            if tripped or silent or now - self._twisted > _STALE:
                self._twisted = np.inf
                self._stage.stop()
            elif self._held and self._goal is not None:
                self._stage.go_to(self._goal)
            self._held = silent
