"""A stage on a Grbl controller (Grbl, grblHAL, FluidNC): every motion is a stream of short jogs.

The control loop only leaves a wish (`JogPlan`); the stage's own thread turns it into relative jogs that reach no
further than a horizon ahead of where the controller is, so that whatever dies, motion ends within it.  A stop is
a jog cancel (0x85), repeated until the stage stands Idle, and a reset where that is in vain; nothing is sent
meanwhile.  Jogs are sent in Idle and Jog alone, so a feed hold at the machine holds the run, too.

Positions are known at the times of status reports; the pose at a frame's time follows from those round it.
"""

import contextlib
import threading
from collections.abc import Iterator

import numpy as np

from exploration.devices import grbl_text
from exploration.devices.grbl_greeting import greet, greet_again, lost_position
from exploration.devices.grbl_link import GrblLink, Heard
from exploration.devices.jog_cancel import JogCancel
from exploration.devices.jog_plan import JogPlan, StreamConfig
from exploration.devices.kinematic_chain import KinematicChain
from exploration.devices.protocols import StageEvent, StageLimits, checked_twist
from exploration.devices.safety import Safety
from exploration.devices.whereabouts import Whereabouts
from primitives.arrays import Floats
from primitives.errors import PalpateError

_OLD = 0.012  # [s] at which a report, going on from it with its speed, is off by too much
_WAITS = 0.05  # [s] at most for a newer one
_ENDS = 1.0  # [s] of the machine's time for the thread to end by itself


class GrblStage:
    """A `MotionStage` on a Grbl controller."""

    def __init__(
        self,
        link: GrblLink,
        chain: KinematicChain,
        limits: StageLimits,
        safety: Safety | None = None,
        config: StreamConfig | None = None,
        crash_pin: str = "",
    ) -> None:
        self._link, self._chain, self._limits, self._safety = link, chain, limits, safety
        self._config, self._pin, self._clock = config or StreamConfig(), crash_pin, link.clock
        self._lock, self._open = threading.RLock(), True
        self.fault = ""  # why the stage will not move any more
        self.state = ""  # as the controller says
        self.reconnects = 0
        self._where = Whereabouts(len(chain.axes))
        self._events: list[StageEvent] = []
        self._plan, self._cancel = JogPlan(chain, limits, self._config), JogCancel(link, self._config)
        self._held = False
        self._as_of: float | None = None
        self._order = greet(link, chain)
        self._hear()
        self._plan.resync(self._where.joints)
        self._thread = threading.Thread(target=self._run, name="stage", daemon=True)
        if safety is not None:
            braking = limits.acceleration
            safety.where = lambda moment: chain.pose(self._where.surely_at(moment, braking))

    @property
    def limits(self) -> StageLimits:
        """What it can do."""
        return self._limits

    def start(self) -> None:
        """Begin to listen and to obey."""
        self._thread.start()

    def as_of(self, moment: float) -> None:
        """From now on `pose` tells where the stage was at a time of its clock, of a frame for example.

        Where the last report is too old to go on from, it waits a little for the next.
        """
        until = moment + _WAITS
        while self._where.moment < moment - _OLD and self._clock.now() < until and not self.fault:
            self._clock.sleep(0.001)
        self._as_of = moment

    def joints(self) -> Floats:
        """(n,) [mm, rad] where the axes are, at the time of `as_of`, or else now."""
        return self._where.joints if self._as_of is None else self._where.at(self._as_of)

    def pose(self) -> Floats:
        """(4, 4) world_from_flange."""
        return self._chain.pose(self.joints())

    def move(self, twist: Floats) -> None:
        """Follow a (6,) twist in the flange frame until told otherwise, or until the wish is stale."""
        wanted = self._limits.shortened(checked_twist(twist))
        if self._safety is not None:
            wanted = self._safety.shortened(wanted, self._limits.acceleration)
        with self._unless_faulty():
            self._plan.follow(wanted, self._clock.now())

    def go_to(self, world_from_flange: Floats) -> None:
        """Start a straight move to a pose; one that the axes cannot take is refused before anything moves."""
        with self._unless_faulty():
            self._plan.head_for(np.array(world_from_flange, dtype=float))
            if self._safety is not None:
                self._safety.goes()

    @property
    def moving(self) -> bool:
        """Whether a `go_to` is under way."""
        if self.fault or (self._safety is not None and self._safety.tripped):
            return False
        return self._plan.goal is not None

    @property
    def held(self) -> bool:
        """Whether frames or reports stay away, a cancel has not ended, or someone holds it at the machine."""
        return self._held or self._cancel.pending or not self._obeys(self._clock.now())

    def stop(self) -> None:
        """Come to rest at once."""
        with self._lock:
            self._plan.drop()
            if self._safety is not None:
                self._safety.answered()
            recent = self._clock.now() < self._plan.until + 0.1
            if recent or self.state in ("Jog", "Hold") or self._link.unanswered:
                self._stop_jogs()

    def events(self) -> tuple[StageEvent, ...]:
        """What was noticed since last asked."""
        with self._lock:
            found, self._events = tuple(self._events), []
            return found if self._safety is None else (*found, *self._safety.untold())

    def close(self) -> None:
        """Stop, and let go of the port."""
        try:
            if self._thread.is_alive():
                self.stop()
                until = self._clock.now() + 1.0
                while self._clock.now() < until and not self.fault:
                    if not self._cancel.pending and self.state != "Jog":
                        break
                    self._clock.sleep(0.005)
        finally:
            self._open = False
            if self._thread.is_alive():
                self._thread.join(_ENDS)
            self._link.port.close()

    def _run(self) -> None:
        while self._open and not self.fault:
            try:
                self._look()
            except PalpateError as error:
                self.fault = self.fault or (self._reconnected(str(error)) if self._open else "")
            except Exception as error:
                self.fault = (
                    f"the stage's thread failed ({type(error).__name__}: {error}); motion has stopped"
                )
        if self._open:
            with contextlib.suppress(PalpateError):
                self._cancel.begin(self._clock.now())

    def _look(self) -> None:
        """One round: listen, judge, send."""
        self._link.ask(self._config.ask)
        heard = self._link.listen()
        with self._lock:
            self._note(heard)
            self._supervise(bool(heard.reports))
            self._feed()

    @contextlib.contextmanager
    def _unless_faulty(self) -> Iterator[None]:
        if self.fault:
            raise PalpateError(self.fault)
        with self._lock:
            yield

    def _hear(self) -> None:
        """Wait for where it is now."""
        now = self._clock.now()
        while self._where.moment < now and self._link.deaf < self._config.dumb:
            self._link.ask()
            self._note(self._link.listen())

    def _note(self, heard: Heard) -> None:
        for moment, report in heard.reports:
            if report.position is None or len(report.position) != len(self._order):
                continue
            self.state = report.state
            self._where.note(moment, self._chain.from_wire(report.position, self._order))
            if self._pin and self._pin in report.pins:
                self._events.append(StageEvent("collision", moment, 0.0, "crash switch"))
                if self._safety is not None and self._plan.twisting:
                    self._safety.tripped = self._safety.tripped or "the crash switch opened"
        why = grbl_text.fault(heard.alarm, heard.errors, self.state, heard.reset and self._where.known)
        self.fault = self.fault or why
        if heard.errors:  # a line that was refused leaves those after it leading elsewhere
            self._stop_jogs()

    def _supervise(self, news: bool) -> None:
        """Whatever must stop motion, looked at every few ms."""
        now = self._clock.now()
        if self._link.deaf > self._config.dumb:
            self.fault = self.fault or "the stage has stopped answering; check its cable and power"
        if news and not self._cancel.pending and self._plan.strayed(self._where.joints):
            self._stop_jogs()
        if self._safety is None:
            return
        if news:
            here = self._chain.pose(self._where.joints)
            self._safety.sent(here, here if self._cancel.pending else self._chain.pose(self._plan.leads_to))
        quiet, tripped = self._safety.silent(now), bool(self._safety.tripped)
        if (quiet or tripped) and (self.state == "Jog" or now < self._plan.until) and self._cancel.again(now):
            self._safety.holds += quiet and not self._held
            self._stop_jogs()
        if tripped:
            self._plan.drop()
        if quiet:
            self._plan.forget_twist()
        elif self._held and not self._cancel.pending:
            self._plan.resume()
        self._held = quiet or (self._cancel.pending and self._held)

    def _stop_jogs(self) -> None:
        self._plan.until = 0.0
        self._cancel.begin(self._clock.now())

    def _obeys(self, now: float) -> bool:
        """Whether jogs may be sent, as far as the controller has told."""
        return self.state in ("Idle", "Jog") and now - self._where.moment <= self._config.deaf

    def _feed(self) -> None:
        """Send what the horizon still lacks."""
        now, here = self._clock.now(), self._where.joints
        if self._cancel.pending:
            self.fault = self.fault or self._cancel.look(self.state, self._where.moment, now)
            if not self._cancel.pending:
                self._plan.resync(here)
            return
        stopped = self._held or self.fault or (self._safety is not None and self._safety.tripped)
        if stopped or not self._obeys(now):
            return
        if self.state == "Idle" and now > self._plan.until + 0.05 and not self._link.unanswered:
            self._plan.resync(here)
            self._plan.stands(here)
        while (jog := self._plan.due(now, here)) is not None:
            if jog.line:
                if not self._link.fits(jog.line):
                    return
                self._link.send(jog.line)
            self._plan.took(jog, now)

    def _reconnected(self, trouble: str) -> str:
        """Wait for a port that went away; the fault, where it stays away or the stage is elsewhere now."""
        before = self._where.joints
        try:
            until = self._clock.now() + self._config.dumb
            if not greet_again(self._link, self._chain, lambda: self._open and self._clock.now() < until):
                return trouble
            self._stop_jogs()
            self._hear()
        except PalpateError as error:
            return str(error)
        self.reconnects += 1
        return lost_position(self._chain, before, self._where.joints)
