"""The clock that devices are read and judged by: the machine's own, or that of an emulated rig.

An emulator that does not get the processor must not look like a device that has died.  It therefore writes its
own time into a small file, and who drives it reads the time there: while the emulator waits for the processor,
time stands still for both, and it may run slower than life on a busy machine.
"""

import mmap
import time
from pathlib import Path

import numpy as np

from primitives.arrays import Floats
from primitives.errors import PalpateError

_SIZE = 8  # bytes of the file: one number, written and read at once, so that nobody sees half of it
_DEAD = 15.0  # [s] of the machine's time without a tick, after which the emulator has ended


class Clock:
    """The machine's own."""

    def now(self) -> float:
        """[s] since some moment."""
        return time.monotonic()

    def sleep(self, seconds: float) -> None:
        """Wait."""
        time.sleep(seconds)


MACHINE = Clock()


class ReadClock(Clock):
    """An emulator's clock, read from its file."""

    def __init__(self, path: Path) -> None:
        try:
            with path.open("rb") as file:
                shared = mmap.mmap(file.fileno(), _SIZE, access=mmap.ACCESS_READ)
        except (OSError, ValueError) as error:
            raise PalpateError(
                f"cannot read the emulator's clock {path}; is palpate hardware emulate running?"
            ) from error
        self._told: Floats = np.frombuffer(shared, np.float64)
        self._last, self._ticked = -1.0, time.monotonic()

    def now(self) -> float:
        """[s] that the emulator has run; raises where it has ended."""
        told = float(self._told[0])
        if told != self._last:
            self._last, self._ticked = told, time.monotonic()
        elif time.monotonic() - self._ticked > _DEAD:
            raise PalpateError("the emulator has ended; start palpate hardware emulate again")
        return told

    def sleep(self, seconds: float) -> None:
        """Wait until the emulator has run so long."""
        until = self.now() + seconds
        while self.now() < until:
            time.sleep(0.0005)


class WrittenClock(Clock):
    """The same from the emulator's side; `tick` as often as it gets to run."""

    def __init__(self, path: Path, pace: float = 1.0, longest: float = 0.005) -> None:
        self._pace, self._longest = pace, longest
        with path.open("w+b") as file:
            file.write(bytes(_SIZE))
            file.flush()
            self._told: Floats = np.frombuffer(mmap.mmap(file.fileno(), _SIZE), np.float64)
        self._now, self._seen = 0.0, time.monotonic()

    def tick(self) -> float:
        """[s] that the emulator has run, `longest` more of the machine's time than at the last tick at most."""
        seen = time.monotonic()
        self._now += self._pace * min(seen - self._seen, self._longest)
        self._seen = seen
        self._told[0] = self._now
        return self._now

    def stand(self) -> None:
        """Let the machine's time pass, and none here."""
        self._seen = time.monotonic()

    def now(self) -> float:
        """[s] at the last tick."""
        return self._now
