"""A matrix as text, as 3D-ViTac's arrays send it: a line of numbers for every row, an empty line after
every frame.

Numbers may be apart by spaces, tabs or commas.  A frame counts when it has exactly its rows, each with
exactly its columns; everything else up to the next empty line is skipped.
"""

import numpy as np

from exploration.devices.wire.stream import Cut, RawFrame
from primitives.arrays import Floats, Ints, frozen

BAUD = 2_000_000
_DIGITS = 10  # of one number with what parts it from the next, at most
_NUMBERS = frozenset(b"0123456789 \t,;")
_COMMAS = bytes.maketrans(b",;\t", b"   ")


def encode(counts: Ints) -> bytes:
    """A frame as the array sends it."""
    lines = (" ".join(map(str, row)) for row in np.asarray(counts).astype(int).tolist())
    return ("\r\n".join(lines) + "\r\n\r\n").encode()


def cut(buffer: bytes, shape: tuple[int, int], begun: bool = True) -> Cut:
    """Frames of (rows, columns) `shape` in a buffer."""
    frames: list[RawFrame] = []
    skipped = at = 0
    longest = shape[0] * (shape[1] * _DIGITS + 2) + 2
    while (end := _blank(buffer, at)) is not None:
        counts = _matrix(buffer[at : end[0]], shape)
        if counts is None:
            skipped += end[1] - at
        else:
            frames.append(RawFrame(frozen(counts)))
        at = end[1]
    rest = buffer[at:]
    if len(rest) > longest:
        skipped += len(rest) - longest
        rest = rest[-longest:]
    return Cut(tuple(frames), rest, skipped, (), True)


def _blank(buffer: bytes, at: int) -> tuple[int, int] | None:
    """Where the next empty line begins and ends."""
    ends = [
        (place, place + len(mark))
        for mark in (b"\r\n\r\n", b"\n\n", b"\n\r\n")
        if (place := buffer.find(mark, at)) >= 0
    ]
    return min(ends, default=None)


def _matrix(block: bytes, shape: tuple[int, int]) -> Floats | None:
    """The rows of the last `shape` lines, or None where they are not that."""
    lines = block.splitlines()
    if len(lines) != shape[0] or not _NUMBERS.issuperset(b"".join(lines)):
        return None
    rows = [line.translate(_COMMAS).split() for line in lines]
    if any(len(row) != shape[1] or max(map(len, row)) >= _DIGITS for row in rows):
        return None
    return np.array([[int(word) for word in row] for row in rows], dtype=np.float64)
