"""One fault at a random moment of a random motion, and what came of it.

What is knowable when: a cable that is pulled, an alarm, a reset and Ctrl-C at once; frames that stop, freeze or
turn to noise when they are overdue by the watchdog's patience; a stage that went deaf at once, as its motion may
go no further than what was sent.  Changed bytes and lost answers need not stop anything, but must not cost the
limit.
"""

from __future__ import annotations

import tempfile
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from devices.judged_rig import LTS, JudgedRig, Truth

from exploration.devices.guard import Guard, GuardLimits
from exploration.devices.safety import SafetyLimits
from exploration.recordings.mcap import Recorder, read
from primitives import pose as se3
from primitives.errors import PalpateError
from recognition.hardware.config import load_device
from recognition.hardware.jog import free
from recognition.hardware.rig import open_rig

FORCE = 30.0  # [N] limit
ENDS, GOES_ON = 5.0, 1.2  # [s] after a fault, until which a run must have ended, or may go on
UNKNOWN = {"alarm": {"error:9"}, "reset in motion": {"error:9"}}  # to lines that were on their way just then
NEED_NOT_STOP = ("byte errors", "garbled answers", "dropped ok")
KINDS = {  # what is ordered, its value, and seconds until it is knowable
    "unplugged array": ("unplug_array", None, 0.0),
    "unplugged stage": ("unplug_stage", None, 0.0),
    "stalled array": ("silent", True, 1.5 * LTS.period + SafetyLimits.patience),
    "frozen frame": ("frozen", True, 1.5 * LTS.period + SafetyLimits.patience + 2 * LTS.period),
    "wrong baud": ("noise", True, 1.5 * LTS.period + SafetyLimits.patience),
    "deaf stage": ("deaf", True, 0.0),
    "alarm": ("alarm", 1, 0.0),
    "reset in motion": ("reset", None, 0.0),
    "Ctrl-C": ("", None, 0.0),
    "byte errors": ("byte_errors", 0.02, np.inf),
    "garbled answers": ("garbled", 0.3, np.inf),
    "dropped ok": ("swallow", 3, np.inf),
}


@dataclass(frozen=True)
class Outcome:
    """What came of one fault."""

    kind: str
    motion: str
    speed: float  # [mm/s] at most, from then until it stood
    stopped: float  # [s] after it was knowable; nan where nothing had to stop
    most_force: float  # [N]
    reason: str  # that the run ended with; empty where it went on
    whole: bool  # the recording
    resumed: str  # empty where it moved again, or why not
    violations: list[str]

    @property
    def wrong(self) -> list[str]:
        """What is not as it must be."""
        stops = self.kind not in NEED_NOT_STOP
        checks = {
            f"stopped {1e3 * self.stopped:.0f} ms late": stops and not self.stopped <= 0.05,
            f"{self.most_force:.1f} N": self.most_force > FORCE,
            "no reason": stops and (not self.reason or "\n" in self.reason),
            "recording not whole": not self.whole,
            f"not resumed: {self.resumed}": bool(self.resumed),
            f"refused: {self.violations}": bool(set(self.violations) - UNKNOWN.get(self.kind, set())),
        }
        return [name for name, is_wrong in checks.items() if is_wrong]


def trial(kind: str, seed: int, pace: float = 1.0) -> Outcome:
    """Move, and let it happen."""
    rng = np.random.default_rng(seed)
    motion = str(rng.choice(["approach", "press", "slide", "transit"]))
    protocol = "lines" if kind == "byte errors" else str(rng.choice(["flexitac", "lines"]))
    height = 40.0 if motion == "transit" else float(rng.uniform(1.0, 4.0))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        with JudgedRig(folder, height, FORCE, seed, pace, protocol) as rig:
            reason, moment = _run(rig, folder / "episode.mcap", kind, motion, rng)
            truth = rig.truth()
            whole = sum(1 for _ in read(folder / "episode.mcap")) > 3
            rig.order(0.0, "mend")
            resumed = _resumed(rig)
            after = rig.truth()
    return _outcome(kind, motion, moment, truth, after, reason, whole, resumed)


def _run(rig: JudgedRig, recording: Path, kind: str, motion: str, rng) -> tuple[str, float]:
    """Drive until the fault ends it, or for a while after; why it ended, and when the fault happened."""
    order, value, until_known = KINDS[kind]
    config = load_device(rig.config)
    reason = ""
    with Recorder(recording) as recorder, closing(open_rig(config)) as devices:

        def record(seen) -> None:
            recorder.frame("lts210", seen.frame, seen.world_from_sensor, np.zeros(6))

        limits = GuardLimits(config.limits.force_n, config.limits.depth_mm, config.limits.reach_mm)
        guard = Guard(devices.stage, [devices.array], [devices.calibration], limits, [record])
        moment = guard.hold(5).time + float(rng.uniform(0.15, 0.9))
        if order:
            rig.order(moment, order, value)
        try:
            for seen in _motion(guard, motion, rng):
                if kind == "Ctrl-C" and seen.time >= moment:
                    moment = config.clock.now()
                    raise KeyboardInterrupt
                if seen.time > moment + (ENDS if np.isfinite(until_known) else GOES_ON):
                    break
        except PalpateError as error:
            reason = str(error)
        except KeyboardInterrupt:
            reason = "interrupted"
    config.clock.sleep(max(0.0, moment - config.clock.now()) + 0.1)
    return reason, moment


def _motion(guard: Guard, motion: str, rng):
    """Ticks of a motion without end."""
    if motion == "transit":
        start, sides = guard.world_from_sensor, (1.0, -1.0)
        while True:
            for side in sides:
                guard.stage.go_to(start @ se3.pose(None, [15.0 * side, 0.0, -5.0 * side]))
                while guard.stage.moving:
                    yield guard.observe()
    wanted, side = float(rng.uniform(4.0, 12.0)), 1.0
    seen = guard.hold()
    begun = seen.time
    while True:
        twist = np.zeros(6)
        toward = 16.0 if seen.force < 0.5 else float(np.clip(0.6 * (wanted - seen.force), -8.0, 8.0))
        twist[2] = toward
        if motion == "slide" and seen.force > 1.0:
            side = 1.0 if np.sin(2.0 * (seen.time - begun)) > 0.0 else -1.0
            twist[0] = 15.0 * side
        if motion == "approach" and seen.force > 2.0:
            twist[2] = -16.0
        seen = guard.move(twist)
        yield seen


def _resumed(rig: JudgedRig) -> str:
    """Whether it can be worked with again, the fault mended; why not, or nothing."""
    try:
        config = load_device(rig.config)
        config.clock.sleep(0.3)
        free(config)
        with closing(open_rig(config)) as devices:
            guard = Guard(devices.stage, [devices.array], [devices.calibration])
            guard.hold(3)
            goal = guard.world_from_sensor @ se3.pose(None, [0.0, 0.0, -5.0])
            guard.go_to(goal)
            guard.hold(10)
            off = float(np.linalg.norm(guard.world_from_sensor[:3, 3] - goal[:3, 3]))
            return "" if off < 0.1 else f"{off:.2f} mm off"
    except PalpateError as error:
        return str(error)


def _outcome(
    kind: str,
    motion: str,
    moment: float,
    truth: Truth,
    after: Truth,
    reason: str,
    whole: bool,
    resumed: str,
) -> Outcome:
    knowable = moment + KINDS[kind][2]
    stopped, speed = np.nan, truth.fastest(moment, moment)
    if np.isfinite(knowable):
        still = truth.retreats_from if kind == "Ctrl-C" else truth.stands_from
        stopped = max(0.0, still(moment) - knowable)
        speed = truth.fastest(moment, knowable + stopped)
    force = float(max(truth.force.max(), after.force.max()))
    return Outcome(kind, motion, speed, stopped, force, reason, whole, resumed, after.violations)
