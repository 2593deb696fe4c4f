"""A Grbl controller to the letter: its dialogue, its states, its planner's motion.

It refuses what Grbl refuses: a jog without F (22), a jog outside Idle and Jog (8, or 9 in alarm), a jog
past the travel (15), a line over 80 bytes (11); bytes beyond the receive buffer of 128 are lost, and
counted as a violation.  Motion follows the queue of lines at one acceleration; the speed where two lines
meet is what junction deviation allows, v^2 = a d s / (1 - s) with s the sine of half the angle between
them, and the queue's end is always a stop.
"""

import re
from collections import deque
from dataclasses import dataclass

import numpy as np

from primitives.arrays import Floats

_BUFFER, _PLANNER, _LINE = 128, 15, 80
_DEVIATION = 0.01  # [mm]
_STEP = 0.001  # [s] of one step of motion
_WORD = re.compile(r"([A-Z])([+-]?\d*\.?\d+)")


@dataclass
class _Block:
    way: Floats  # (n,) unit
    left: float  # [mm or deg] still to go
    speed: float  # [1/s]


class GrblMachine:
    """Its state; `receive` bytes, `advance` in time, `reply` bytes."""

    def __init__(self, letters: str, position: Floats, travel: Floats, acceleration: float = 2000.0) -> None:
        self.letters, self.position = letters, np.array(position, dtype=float)
        self._travel, self._acceleration = np.asarray(travel), acceleration
        self.state = "Idle"
        self.replies: list[bytes] = []
        self.violations: list[str] = []
        self.pins = ""
        self._queue: deque[_Block] = deque()
        self._lines: deque[bytes] = deque()
        self._typed = b""
        self._speed = 0.0
        self._canceling = False
        self._ends: Floats = self.position.copy()
        self.swallow_ok = 0  # answers that get lost
        self.moved = False

    def receive(self, data: bytes) -> None:
        """Bytes from the host; realtime ones are obeyed out of band."""
        for byte in data:
            if byte == 0x3F:
                self.replies.append(self._report())
            elif byte == 0x85:
                if self.state == "Jog":
                    self._canceling = True
            elif byte == 0x21:
                self.state = "Hold" if self.state == "Jog" else self.state
            elif byte == 0x7E:
                self.state = "Jog" if self.state == "Hold" else self.state
            elif byte == 0x18:
                self._reset()
            elif sum(map(len, self._lines)) + len(self._typed) >= _BUFFER:
                self.violations.append("buffer overrun")
            elif byte in (0x0A, 0x0D):
                if self._typed:
                    self._lines.append(self._typed)
                self._typed = b""
            else:
                self._typed += bytes([byte])
        self._parse()

    @property
    def standing(self) -> bool:
        """Whether nothing moves."""
        return self._speed == 0.0

    def alarm(self, number: int) -> None:
        """Something happened: stop, and stand in alarm."""
        self._queue.clear()
        self._speed, self._canceling, self.state = 0.0, False, "Alarm"
        self._ends = self.position.copy()
        self.replies.append(b"ALARM:%d\r\n" % number)

    def advance(self, seconds: float) -> None:
        """Move for some time."""
        self.moved = False
        while seconds > 1e-9:
            step = min(_STEP, seconds)
            seconds -= step
            if self._queue or self._canceling:
                self._move(step)
        self._parse()

    def _move(self, step: float) -> None:
        a = self._acceleration
        if self._canceling or self.state == "Hold":
            self._speed = max(0.0, self._speed - a * step)
            if self._speed == 0.0 and self._canceling:
                self._queue.clear()
                self._canceling, self.state, self._ends = False, "Idle", self.position.copy()
        elif self._queue:
            block = self._queue[0]
            allowed = np.sqrt(self._exit() + 2.0 * a * block.left)
            self._speed = max(min(self._speed + a * step, block.speed, allowed), 0.02 * a * step)
        go = self._speed * step
        while go > 0.0 and self._queue:
            block = self._queue[0]
            part = min(go, block.left)
            self.position += part * block.way
            self.moved = True
            block.left -= part
            go -= part
            if block.left < 1e-9:
                self._queue.popleft()
        if not self._queue and self.state == "Jog":
            self._speed, self.state, self._canceling = 0.0, "Idle", False
            self.position = self._ends.copy()

    def _exit(self) -> float:
        """Square of the speed with which the first block may end."""
        entry, blocks, a = 0.0, list(self._queue), self._acceleration
        for i in range(len(blocks) - 1, 0, -1):
            corner = float(-(blocks[i - 1].way @ blocks[i].way))
            half = np.sqrt(max(0.0, 0.5 * (1.0 - corner)))
            junction = 0.0 if corner > 0.999999 else a * _DEVIATION * half / max(1e-9, 1.0 - half)
            entry = min(
                junction, blocks[i].speed ** 2, blocks[i - 1].speed ** 2, entry + 2 * a * blocks[i].left
            )
        return entry

    def _report(self) -> bytes:
        place = ",".join(f"{x:.3f}" for x in self.position)
        free = _BUFFER - 1 - sum(map(len, self._lines)) - len(self._typed)
        pins = f"|Pn:{self.pins}" if self.pins else ""
        state = f"Hold:{int(not self.standing)}" if self.state == "Hold" else self.state
        return f"<{state}|MPos:{place}|Bf:{_PLANNER - len(self._queue)},{free}|FS:0,0{pins}>\r\n".encode()

    def _reset(self) -> None:
        moving = bool(self._queue)
        self._lines.clear()
        self._typed = b""
        self._queue.clear()
        self._speed, self._canceling, self._ends = 0.0, False, self.position.copy()
        self.replies.append(b"\r\nGrbl 1.1h ['$' for help]\r\n")
        self.state = "Alarm" if moving or self.state == "Alarm" else "Idle"
        if moving:
            self.replies.append(b"ALARM:3\r\n")

    def _parse(self) -> None:
        while self._lines and not self._canceling and len(self._queue) < _PLANNER:
            answer = self._obey(self._lines.popleft())
            if self.swallow_ok:
                self.swallow_ok -= 1
                continue
            self.replies.append(b"ok\r\n" if answer == 0 else b"error:%d\r\n" % answer)
            if answer in (8, 9, 11, 22):
                self.violations.append(f"error:{answer}")

    def _obey(self, raw: bytes) -> int:
        line = raw.decode("ascii", "replace").replace(" ", "").upper()
        if len(raw) >= _LINE:
            return 11
        if line == "$I":
            self.replies.append(
                f"[VER:1.1h.emulated:]\r\n[AXS:{len(self.letters)}:{self.letters}]\r\n".encode()
            )
            return 0
        if line == "$X":
            self.state = "Idle" if self.state == "Alarm" else self.state
            return 0
        if line == "$H":
            self.state = "Idle"
            return 0
        if not line.startswith("$J="):
            return 0 if line in ("$$", "$G", "$#", "") else (9 if self.state == "Alarm" else 20)
        if self.state not in ("Idle", "Jog"):
            return 9 if self.state == "Alarm" else 8
        words = dict(_WORD.findall(line[3:].replace("G91", "").replace("G21", "")))
        if "F" not in words or float(words["F"]) <= 0.0:
            return 22
        step = np.array([float(words.get(c, 0.0)) for c in self.letters])
        ends = self._ends + step
        if (np.abs(ends) > self._travel).any():
            return 15
        length = float(np.linalg.norm(step))
        if length > 0.0:
            self._queue.append(_Block(step / length, length, float(words["F"]) / 60.0))
            self._ends, self.state = ends, "Jog"
        return 0
