"""The dialogue with a Grbl controller: lines that it has room for, and reports with the time that they hold for.

Every byte sent is counted until its `ok` or `error:N` has come, and no line is sent that would not fit
into the receive buffer.  A report's time is the middle between its question and the soonest answer of late: one
that took longer was held up on its way back.
"""

import re
from collections import deque
from dataclasses import dataclass, field

from exploration.devices import grbl_text
from exploration.devices.clock import MACHINE, Clock
from exploration.devices.ports import Port
from primitives.errors import PalpateError

_BUFFER = 127  # bytes of the smallest receive buffer
_UNHEARD = 0.2  # [s] after which a question was not heard
_AWAY = 0.1  # [s] between two looks, beyond which nobody listened
_OBEYED = 0.05  # [s] after which a line has begun to be obeyed, so that Idle means it was answered
_TURNS = 31  # answers whose soonest tells how long one takes
_LOST = 1.0  # [s] after which an answer that has not come will not


@dataclass
class Heard:
    """What one look at the port brought."""

    reports: list[tuple[float, grbl_text.Status]] = field(default_factory=list)  # with the time they hold for
    errors: list[int] = field(default_factory=list)
    alarm: int | None = None
    reset: bool = False  # it said hello again
    other: list[str] = field(default_factory=list)


class GrblLink:
    """One controller on a port; used by one thread at a time."""

    def __init__(self, port: Port, clock: Clock = MACHINE) -> None:
        self.port, self.clock = port, clock
        self._text = b""
        self._sent: deque[tuple[int, float, float]] = deque()  # bytes, when, and after how much listening
        self._heard = 0.0  # [s] of listening; what nobody listened to does not count
        self._asked = self._last_asked = 0.0
        self._turns: deque[float] = deque(maxlen=_TURNS)  # [s] from a question to its answer
        self._patience = _LOST
        self._listened = clock.now()
        self.deaf = 0.0  # [s] of listening without a report
        self._offset: tuple[float, ...] = ()
        self.lost = 0  # answers that never came
        self.garbled = 0  # lines that were not understood

    @property
    def unanswered(self) -> int:
        """Lines whose answer has not come."""
        return len(self._sent)

    def fits(self, line: str) -> bool:
        """Whether a line may be sent now."""
        return sum(size for size, _, _ in self._sent) + len(line) + 1 <= _BUFFER

    def send(self, line: str) -> None:
        """A line that fits."""
        data = line.encode() + b"\n"
        if len(data) > grbl_text.LINE:
            raise PalpateError(f"a line of {len(data)} bytes is too long for Grbl: {line}")
        self._sent.append((len(data), self.clock.now(), self._heard))
        self.port.write(data)

    def realtime(self, byte: bytes) -> None:
        """`!` hold, `~` resume, 0x18 reset, 0x85 cancel a jog."""
        self.port.write(byte)
        if byte == b"\x18":
            self._sent.clear()

    def ask(self, pause: float = 0.0) -> None:
        """Ask for a report, unless one is on its way, or was asked for within a pause [s]."""
        now = self.clock.now()
        if now - self._last_asked < pause:
            return
        if not self._asked or now - self._asked > _UNHEARD:
            self._asked = self._last_asked = now
            self.port.write(b"?")

    def forget(self) -> None:
        """The port was away: nothing that was begun on it will be ended."""
        self._text, self._asked, self.deaf = b"", 0.0, 0.0
        self._sent.clear()

    def listen(self) -> Heard:
        """What has come, after waiting a moment."""
        heard = Heard()
        data = self.port.read()
        now = self.clock.now()
        passed = min(now - self._listened, _AWAY)
        self.deaf, self._heard, self._listened = self.deaf + passed, self._heard + passed, now
        *lines, self._text = (self._text + data).split(b"\n")
        self._text = self._text[-512:]
        for raw in lines:
            self._understand(raw.decode("ascii", "replace").strip(), now, heard)
        while self._sent and self._heard - self._sent[0][2] > self._patience:
            self._sent.popleft()
            self.lost += 1
        return heard

    def _understand(self, line: str, now: float, heard: Heard) -> None:
        if offset := grbl_text.work_offset(line):
            self._offset = offset
        if (report := grbl_text.status(line, self._offset)) is not None:
            asked, self._asked = self._asked, 0.0
            self.deaf = 0.0
            heard.reports.append((self._held(asked, now), report))
            if report.state == "Idle" and self._sent and asked - self._sent[-1][1] > _OBEYED:
                self.lost += len(self._sent)
                self._sent.clear()
        elif line == "ok" or (error := re.fullmatch(r"error:(\d+)", line)):
            if self._sent:
                self._sent.popleft()
            if line != "ok" and error:
                heard.errors.append(int(error[1]))
        elif alarm := re.fullmatch(r"ALARM:(\d+)", line):
            heard.alarm = int(alarm[1])
        elif re.match(r"Grbl|GrblHAL", line):
            heard.reset = True
            self._sent.clear()
        elif line.startswith("["):
            heard.other.append(line)
        elif line:
            self.garbled += 1

    def _held(self, asked: float, now: float) -> float:
        """[s] for which a report holds; one that came unasked holds when it came."""
        if not asked:
            return now
        self._turns.append(now - asked)
        return asked + min(self._turns) / 2

    def exchange(self, line: str, patience: float) -> Heard:
        """Send a line and wait for its answer; everything heard until then."""
        before, self._patience = self.lost, patience
        self.send(line)
        total, until = Heard(), self._heard + patience
        while self._sent and self._heard < until:
            heard = self.listen()
            total.reports += heard.reports
            total.errors += heard.errors
            total.other += heard.other
            total.alarm = heard.alarm if heard.alarm is not None else total.alarm
        self._patience = _LOST
        if self._sent or self.lost > before:
            raise PalpateError(
                f"no answer from {self.port.address}; is it a Grbl controller, and the baud rate right?"
            )
        return total
