"""What Grbl, grblHAL and FluidNC say and are told, as pure functions of text."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

LINE = 80  # bytes, with its end
ERRORS = {
    8: "it moves or stands in alarm",
    9: "it is locked by an alarm or a move",
    15: "the move would leave its travel",
    22: "a feed rate is missing",
    11: "a line is too long",
}
ALARMS = {
    1: "a limit switch was met",
    2: "a move would leave its travel",
    3: "it was reset in motion",
    4: "the probe did not start clear",
    5: "the probe met nothing",
    6: "homing was reset",
    7: "the door opened while homing",
    8: "homing did not clear a switch",
    9: "homing found no switch",
}
TRAVEL = (2, 15)  # errors that say that a move would leave the travel
_NUMBER = re.compile(r"^[+-]?\d+(\.\d*)?$")


@dataclass(frozen=True)
class Status:
    """A status report."""

    state: str  # Idle, Jog, Run, Hold, Alarm, Home, Door, Check, Sleep
    position: tuple[float, ...] | None  # of the machine [mm, deg]
    pins: str = ""  # P: the probe, X Y Z A B C: limits, D H R S: door, hold, reset, start
    blocks: int | None = None  # free in the planner


def status(line: str, offset: Sequence[float] = ()) -> Status | None:
    """A report `<Idle|MPos:...|...>`, or None where the line is none; `offset` is the last WCO, for WPos."""
    if not (line.startswith("<") and line.endswith(">")):
        return None
    state, *fields = line[1:-1].split("|")
    told = dict(field.split(":", 1) for field in fields if ":" in field)
    position = _numbers(told.get("MPos", ""))
    work = _numbers(told.get("WPos", ""))
    if position is None and work is not None and len(offset) == len(work):
        position = tuple(w + o for w, o in zip(work, offset, strict=True))
    buffers = _numbers(told.get("Bf", ""))
    return Status(state.split(":")[0], position, told.get("Pn", ""), int(buffers[0]) if buffers else None)


def fault(alarm: int | None, errors: Sequence[int], state: str, reset: bool) -> str:
    """Why a stage that says so will not move any more; empty where it may."""
    free = "free it, then palpate hardware jog CONFIG --unlock, and --home"
    if alarm is not None:
        return f"the stage raised alarm {alarm} ({ALARMS.get(alarm, 'its manual says why')}); {free}"
    if state == "Alarm":
        return f"the stage went into alarm; {free}"
    if any(number in TRAVEL for number in errors):
        return "the stage would leave its travel; lessen the workspace in the config"
    return "the stage was reset; home it (palpate hardware jog CONFIG --home), then begin again" * reset


def work_offset(line: str) -> tuple[float, ...] | None:
    """The WCO of a report that has one."""
    found = re.search(r"\|WCO:([^|>]*)", line)
    return _numbers(found[1]) if found else None


def jog(letters: str, steps: Sequence[float], feed: float) -> str:
    """A relative jog by `steps` [mm, deg] at `feed` [1/min], without its line's end; empty where nothing moves."""
    words = "".join(f"{c}{x:.3f}" for c, x in zip(letters, steps, strict=True) if abs(x) > 0.0004)
    return f"$J=G91G21{words}F{max(feed, 1.0):.1f}" if words else ""


def _numbers(text: str) -> tuple[float, ...] | None:
    words = text.split(",")
    return tuple(map(float, words)) if all(_NUMBER.match(word) for word in words) else None
