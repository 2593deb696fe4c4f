"""A stream of bytes cut into frames, wherever in the stream one begins to listen.

A protocol is a pure function `cut(buffer, locked) -> Cut`: what the bytes hold, and the bytes that wait
for more. `Stream` keeps those between reads.  What waits is never longer than the longest frame, so a
stream of noise costs no memory; bytes that belong to no frame are counted.
"""

from collections.abc import Callable
from dataclasses import dataclass

from primitives.arrays import Floats


@dataclass(frozen=True)
class RawFrame:
    """One reading as the wire carried it."""

    counts: Floats  # (n,) or (rows, columns)
    device_time: float | None = None  # [s] on the array's own clock, where it has one
    sequence: int | None = None  # the array's own count of frames, where it has one


@dataclass(frozen=True)
class Reply:
    """An answer that is no frame."""

    id: int
    payload: bytes


@dataclass(frozen=True)
class Cut:
    """What a buffer held."""

    frames: tuple[RawFrame, ...]
    rest: bytes  # waits for more
    skipped: int  # bytes that belonged to nothing
    replies: tuple[Reply, ...] = ()
    locked: bool = False  # whether the place of the next frame is known


Cutter = Callable[[bytes, bool], Cut]


class Stream:
    """One array's bytes, as they come."""

    def __init__(self, cut: Cutter) -> None:
        self._cut = cut
        self._rest = b""
        self._locked = False
        self.skipped = 0  # bytes that belonged to nothing
        self.replies: list[Reply] = []  # since they were last taken

    @property
    def waiting(self) -> int:
        """Bytes of a frame that has begun."""
        return len(self._rest)

    def feed(self, data: bytes) -> tuple[RawFrame, ...]:
        """The frames that these bytes complete."""
        cut = self._cut(self._rest + data, self._locked)
        self._rest, self._locked = cut.rest, cut.locked
        self.skipped += cut.skipped
        self.replies.extend(cut.replies)
        return cut.frames

    def gap(self) -> None:
        """The line fell silent: what has begun will not be completed, and what comes next is a beginning."""
        self.skipped += len(self._rest)
        self._rest = b""
        self._locked = True
