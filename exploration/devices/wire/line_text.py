r"""Palpate's own minimal format, for arrays that one builds: a frame is one checked line of text.

    $17,1234,10,12,250,11*2F\n

`$`, the frame's number, the array's clock in ms, the taxels row by row (x fastest), `*`, and as two
hexadecimal digits the exclusive or of all bytes between `$` and `*`.  A number that is missing shows in
the first field, a byte that was changed in the last.
"""

from functools import reduce
from operator import xor

import numpy as np

from exploration.devices.wire.stream import Cut, RawFrame
from primitives.arrays import Floats, Ints, frozen

BAUD = 115200
_DIGITS = 11  # of one number with its comma, at most
_NUMBERS = frozenset(b"0123456789,")


def encode(counts: Ints, sequence: int, milliseconds: int) -> bytes:
    """A frame as the array sends it."""
    body = ",".join(
        map(str, [sequence, milliseconds, *np.asarray(counts).astype(int).ravel().tolist()])
    ).encode()
    return b"$%b*%02X\n" % (body, reduce(xor, body))


def cut(buffer: bytes, cells: int) -> Cut:
    """Frames of `cells` taxels in a buffer."""
    frames: list[RawFrame] = []
    skipped = at = 0
    longest = (cells + 2) * _DIGITS + 6
    while (end := buffer.find(b"\n", at)) >= 0:
        start = buffer.rfind(b"$", at, end)
        frame = _frame(buffer[start + 1 : end], cells) if start >= 0 else None
        if frame is None:
            skipped += end + 1 - at
        else:
            skipped += start - at
            frames.append(frame)
        at = end + 1
    rest = buffer[at:]
    start = rest.rfind(b"$")
    keep = rest[start:] if start >= 0 and len(rest) - start <= longest else b""
    return Cut(tuple(frames), keep, skipped + len(rest) - len(keep))


def _frame(line: bytes, cells: int) -> RawFrame | None:
    body, star, check = line.rstrip(b"\r").rpartition(b"*")
    if not star or not body or len(check) != 2 or not _NUMBERS.issuperset(body):
        return None
    if b"%02X" % reduce(xor, body) != check.upper():
        return None
    words = body.split(b",")
    if len(words) != cells + 2 or not all(0 < len(word) < _DIGITS for word in words):
        return None
    counts: Floats = np.array([int(word) for word in words[2:]], dtype=np.float64)
    return RawFrame(frozen(counts), int(words[1]) / 1000.0, int(words[0]))
