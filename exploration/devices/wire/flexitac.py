"""FlexiTac: `AA 55`, then rows * columns bytes; no length, no check, no sequence, at 2 Mbaud.

The marker may occur among the values, so a place is believed only when a second marker stands one frame
behind it, or when it came first after a silence.  Once locked, every frame must begin with the marker;
where one does not, the lock is lost.  A value that was changed on the way cannot be told from a true
one.
"""

import numpy as np

from exploration.devices.wire.stream import Cut, RawFrame
from primitives.arrays import Ints, frozen

BAUD = 2_000_000
MARKER = b"\xaa\x55"


def encode(counts: Ints) -> bytes:
    """A frame as the array sends it."""
    return MARKER + np.asarray(counts).astype(np.uint8).tobytes()


def cut(buffer: bytes, cells: int, locked: bool) -> Cut:
    """Frames of `cells` taxels in a buffer."""
    length = len(MARKER) + cells
    frames: list[RawFrame] = []
    at = skipped = 0
    while True:
        if not locked:
            place = _believed(buffer, at, length)
            if place is None:
                keep = max(
                    at, len(buffer) - length - 1
                )  # a frame may have begun there, its second marker to come
                return Cut(tuple(frames), buffer[keep:], skipped + keep - at)
            skipped += place - at
            at, locked = place, True
        left = buffer[at : at + len(MARKER)]
        if left != MARKER[: len(left)]:
            locked = False
            continue
        if len(buffer) - at < length:
            return Cut(tuple(frames), buffer[at:], skipped, (), True)
        values = np.frombuffer(buffer, np.uint8, cells, at + len(MARKER))
        frames.append(RawFrame(frozen(values.astype(np.float64))))
        at += length


def _believed(buffer: bytes, at: int, length: int) -> int | None:
    """Where a marker stands with another one frame behind it."""
    while (place := buffer.find(MARKER, at)) >= 0:
        if buffer[place + length : place + length + len(MARKER)] == MARKER:
            return place
        at = place + 1
    return None
