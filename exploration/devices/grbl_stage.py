"""A stage on a Grbl controller (Grbl, grblHAL, FluidNC): every motion is a stream of short jogs.

The control loop only leaves a wish, a twist or a goal; the stage's own thread turns it into relative
jogs that reach no further than a horizon ahead of where the controller is, so that whatever dies, motion
ends within it.  A wish is old after a moment and then counts as none.  The horizon is what the
controller needs to keep its speed, v / (2 a) [s], and a margin.  A stop is a jog cancel (0x85); nothing
is sent until the stage stands Idle again. Jogs are sent in Idle and Jog alone.

Positions are known at the times of status reports, which are asked for as often as they are answered;
the pose at a frame's time lies between two of them.
"""

import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from exploration.devices import grbl_text
from exploration.devices.grbl_link import GrblLink, Heard
from exploration.devices.guard import Collision
from exploration.devices.kinematic_chain import KinematicChain
from exploration.devices.protocols import StageEvent, StageLimits
from exploration.devices.safety import Safety
from primitives import pose as se3
from primitives.arrays import Floats
from primitives.errors import PalpateError


@dataclass(frozen=True)
class StreamConfig:
    """How motion is cut into jogs."""

    margin: float = 0.02  # [s] of motion that is sent ahead, beyond what the speed needs
    shortest: float = 0.008  # [s] of one jog
    stale: float = 0.15  # [s] after which a twist counts as none
    dumb: float = 1.0  # [s] without a report, after which the stage is lost
    deaf: float = 0.1  # [s] without a report, after which nothing is sent
    step: float = 2.0  # [mm] or of a pad turned so far, of one jog of a straight move
    again: float = 0.05  # [s] between two cancels


class GrblStage:
    """A `MotionStage` on a Grbl controller."""

    def __init__(
        self,
        link: GrblLink,
        chain: KinematicChain,
        limits: StageLimits,
        safety: Safety | None = None,
        config: StreamConfig = StreamConfig(),
        crash_pin: str = "",
    ) -> None:
        self._link, self._chain, self._limits, self._safety = link, chain, limits, safety
        self._config, self._pin = config, crash_pin
        self._lock = threading.RLock()
        self._open = True
        self.fault = ""  # why the stage will not move any more
        self._state = ""
        self._samples: deque[tuple[float, Floats]] = deque(maxlen=256)
        self._reported = time.monotonic()
        self._events: list[StageEvent] = []
        self._twist, self._twist_time = np.zeros(6), 0.0
        self._goal: Floats | None = None
        self._way: deque[tuple[Floats, float]] = deque()  # joint positions and seconds to them
        self._planned: Floats = np.zeros(len(chain.axes))  # where everything sent will lead
        self._sent: Floats = np.zeros(len(chain.axes))  # the same as the controller rounds it
        self._until = 0.0  # [s] when what was sent will have been done
        self._canceling = 0.0  # when the jogs were canceled last; 0: they were not
        self._held = False
        self._as_of: float | None = None
        self.clock: Callable[[], float | None] = lambda: None
        self._connect()
        self._thread = threading.Thread(target=self._run, name="stage", daemon=True)

    @property
    def limits(self) -> StageLimits:
        """What it can do."""
        return self._limits

    def start(self) -> None:
        """Begin to listen and to obey."""
        self._thread.start()

    def as_of(self, moment: float) -> None:
        """From now on `pose` tells where the stage was at a time of `time.monotonic`, of a frame for example."""
        until = time.monotonic() + 0.03
        while self._samples[-1][0] < moment and time.monotonic() < until and not self.fault:
            time.sleep(0.0005)
        self._as_of = moment

    def joints(self) -> Floats:
        """(n,) [mm, rad] where the axes are, at the time of `as_of`, or else now."""
        samples = list(self._samples)
        last = samples[-1]
        moment = self._as_of
        if moment is None or len(samples) < 2 or moment >= last[0]:
            return last[1]
        for before, after in zip(reversed(samples[:-1]), reversed(samples[1:]), strict=True):
            if before[0] <= moment:
                share = (moment - before[0]) / max(after[0] - before[0], 1e-9)
                return np.asarray(before[1] + share * (after[1] - before[1]))
        return samples[0][1]

    def pose(self) -> Floats:
        """(4, 4) world_from_flange."""
        return self._chain.pose(self.joints())

    def move(self, twist: Floats) -> None:
        """Follow a (6,) twist in the flange frame until told otherwise, or until the wish is stale."""
        wanted = np.array(twist, dtype=float)
        if wanted.shape != (6,) or not np.isfinite(wanted).all():
            raise PalpateError(f"a twist is six finite numbers (mm/s, rad/s), not {twist!r}")
        self._require_sound()
        with self._lock:
            self._twist, self._twist_time = self._bounded(wanted), time.monotonic()
            self._goal = None
            self._way.clear()

    def go_to(self, world_from_flange: Floats) -> None:
        """Start a straight move to a pose; one that the axes cannot take is refused before anything moves."""
        self._require_sound()
        goal = np.array(world_from_flange, dtype=float)
        with self._lock:
            way = self._straight(goal)
            self._twist = np.zeros(6)
            self._goal, self._way = goal, way

    @property
    def moving(self) -> bool:
        """Whether a `go_to` is under way."""
        if self.fault or (self._safety is not None and self._safety.tripped):
            return False
        return self._goal is not None

    def stop(self) -> None:
        """Come to rest at once."""
        with self._lock:
            self._twist, self._goal = np.zeros(6), None
            self._way.clear()
            if self._safety is not None:
                self._safety.answered()
            if self._state == "Jog" or self._link.unanswered or time.monotonic() < self._until + 0.1:
                self._cancel()

    def events(self) -> tuple[StageEvent, ...]:
        """What was noticed since last asked."""
        with self._lock:
            found, self._events = tuple(self._events), []
        return found

    def close(self) -> None:
        """Stop, and let go of the port."""
        if self._thread.is_alive():
            self.stop()
            until = time.monotonic() + 1.0
            while time.monotonic() < until and not self.fault and (self._canceling or self._state == "Jog"):
                time.sleep(0.005)
        self._open = False
        if self._thread.is_alive():
            self._thread.join(0.5)
        self._link.port.close()

    def _require_sound(self) -> None:
        if self.fault:
            raise PalpateError(self.fault)

    def _bounded(self, twist: Floats) -> Floats:
        lim = self._limits
        for part, most in ((slice(0, 3), lim.speed), (slice(3, 6), lim.turn_speed)):
            size = float(np.linalg.norm(twist[part]))
            if size > most:
                twist[part] *= most / size
        return twist

    def _connect(self) -> None:
        link, until = self._link, time.monotonic() + 3.0
        while time.monotonic() < until:
            link.ask()
            heard = link.listen()
            self._note(heard)
            if heard.reports:
                break
            time.sleep(0.01)
        else:
            raise PalpateError(
                f"no answer from {link.port.address}; is it a Grbl controller, and the baud rate right?"
            )
        if self._state == "Alarm":
            raise PalpateError(
                "the stage is in alarm: home it (palpate hardware jog CONFIG --home), then begin again"
            )
        if not self._samples:
            raise PalpateError("the stage reports no machine position; set $10=1")
        axes = next((line for line in link.exchange("$I", 2.0).other if line.startswith("[AXS:")), "")
        letters = axes.rstrip("]").split(":")[-1] if axes else "XYZ"[: len(self._chain.axes)]
        told = "".join(axis.letter for axis in self._chain.axes)
        if sorted(letters) != sorted(told):
            raise PalpateError(
                f"the controller has the axes {letters}, the config {told}; correct the config"
            )
        self._order = [told.index(letter) for letter in letters]

    def _run(self) -> None:
        try:
            while self._open:
                self._link.ask()
                self._note(self._link.listen())
                with self._lock:
                    self._supervise()
                    self._feed()
        except PalpateError as error:
            self.fault = self.fault or str(error)
        except Exception as error:
            self.fault = f"the stage's thread failed ({type(error).__name__}: {error}); motion has stopped"
            self._link.realtime(b"\x85")

    def _note(self, heard: Heard) -> None:
        for moment, report in heard.reports:
            if report.position is None or len(report.position) != len(self._chain.axes):
                continue
            self._state, self._reported = report.state, moment
            order = getattr(self, "_order", range(len(report.position)))
            position = np.zeros(len(report.position))
            position[list(order)] = report.position
            self._samples.append((moment, position / self._chain.to_wire))
            if self._pin and self._pin in report.pins:
                self._events.append(StageEvent("collision", moment, 0.0, "crash switch"))
                if self._safety is not None and self._safety.tripped == "" and self._twist.any():
                    self._safety.tripped = "the crash switch opened"
        if heard.alarm is not None:
            why = grbl_text.ALARMS.get(heard.alarm, "its manual says why")
            self.fault = (
                f"the stage raised alarm {heard.alarm} ({why}); free it, then palpate hardware jog --home"
            )
        if heard.reset and self._samples:
            self.fault = self.fault or "the stage was reset; home it, then begin again"
        for number in heard.errors:
            if number in (15, 2):
                self.fault = "the stage would leave its travel; lessen the workspace in the config"
            self._resync()

    def _supervise(self) -> None:
        """Whatever must stop motion, looked at every few ms."""
        now = time.monotonic()
        if self._state == "Alarm" and not self.fault:
            self.fault = "the stage went into alarm; free it, then palpate hardware jog --home"
        if now - self._reported > self._config.dumb and not self.fault:
            self.fault = "the stage has stopped answering; check its cable and power"
            self._cancel()
        if self._safety is None:
            return
        self._safety.at(self._chain.pose(self._samples[-1][1])[:3, 3])
        quiet = self._safety.silent(now)
        busy = self._state == "Jog" or now < self._until
        if (quiet or self._safety.tripped) and busy and now - self._canceling > self._config.again:
            self._safety.holds += quiet and not self._held
            self._cancel()
        if self._safety.tripped:
            self._twist, self._goal = np.zeros(6), None
            self._way.clear()
        if quiet:
            self._twist = np.zeros(6)
        elif self._held and self._goal is not None and not self._canceling:
            self._way = self._straight(self._goal)
        self._held = quiet or bool(self._canceling and self._held)

    def _cancel(self) -> None:
        self._link.realtime(b"\x85")
        self._canceling = time.monotonic()
        self._until = 0.0

    def _feed(self) -> None:
        """Send what the horizon still lacks."""
        now, config = time.monotonic(), self._config
        if self._canceling:
            fresh = self._reported > self._canceling
            if fresh and self._state == "Idle" and not self._link.unanswered:
                self._canceling = 0.0
                self._resync()
            elif fresh and self._state == "Jog" and now - self._canceling > config.again:
                self._cancel()
            return
        stopped = self._held or self.fault or (self._safety is not None and self._safety.tripped)
        if stopped or self._state not in ("Idle", "Jog") or now - self._reported > config.deaf:
            return
        if self._state == "Idle" and now > self._until + 0.05 and not self._link.unanswered:
            self._resync()
            if self._goal is not None and not self._way:
                self._goal = None
        speed = self._limits.speed if self._goal is not None else float(np.linalg.norm(self._twist[:3]))
        ahead = speed / (2.0 * self._limits.acceleration) + config.margin
        behind = np.abs(self._planned - self._samples[-1][1]) / self._chain.speed
        while max(self._until, now) - now < ahead and float(behind.max()) < 2.0 * ahead + 0.1:
            if not self._one_jog(now):
                return

    def _one_jog(self, now: float) -> bool:
        """The next jog of a goal's way or of a twist; whether one was sent."""
        if self._way:
            joints, seconds = self._way[0]
        elif self._twist.any() and now - self._twist_time < self._config.stale:
            seconds = self._config.shortest
            here = self._chain.pose(self._planned)
            reached = self._chain.reach(here @ se3.exp(self._twist * seconds), self._planned, 6)
            joints = reached.q
        else:
            return False
        seconds = max(seconds, float((np.abs(joints - self._planned) / self._chain.speed).max()))
        wire = np.round((joints - self._sent) * self._chain.to_wire, 3)
        feed = float(np.linalg.norm(wire)) / seconds * 60.0
        letters = "".join(axis.letter for axis in self._chain.axes)
        line = grbl_text.jog(letters, wire.tolist(), feed)
        if line and not self._link.fits(line):
            return False
        if line:
            self._link.send(line)
            self._sent = self._sent + wire / self._chain.to_wire
        if self._way:
            self._way.popleft()
        self._planned = joints
        self._until = max(self._until, now) + seconds
        return True

    def _straight(self, goal: Floats) -> deque[tuple[Floats, float]]:
        """The joint positions of a straight way from where everything sent leads."""
        start = self._chain.pose(self._planned)
        line = goal[:3, 3] - start[:3, 3]
        turn = se3.rotation_log(goal[:3, :3] @ start[:3, :3].T)
        length, angle = float(np.linalg.norm(line)), float(np.linalg.norm(turn))
        seconds = max(length / self._limits.speed, angle / self._limits.turn_speed)
        count = max(1, int(np.ceil(max(length / self._config.step, angle / 0.04))))
        way: deque[tuple[Floats, float]] = deque()
        q = self._planned
        for k in range(1, count + 1):
            between = np.eye(4)
            between[:3, :3] = se3.rotation_exp(turn * k / count) @ start[:3, :3]
            between[:3, 3] = start[:3, 3] + line * k / count
            reached = self._chain.reach(between, q)
            if not reached and k == count:
                raise Collision(
                    f"the stage cannot take that pose ({reached.off:.1f} mm, "
                    f"{np.degrees(reached.turned):.1f} deg off); "
                    "what lies there stays unknown"
                )
            q = reached.q
            way.append((q, seconds / count))
        return way

    def _resync(self) -> None:
        """What was sent counts for nothing any more: plan from where the stage is."""
        here = self._samples[-1][1]
        if float(np.abs((here - self._sent) * self._chain.to_wire).max()) > 0.002:
            self._planned = here
        self._sent = here
