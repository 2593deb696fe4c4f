"""The Weiss DSA's controller (DSACON32m): matrices of pressure cells, run-length coded at will.

A frame (id 00) is `timestamp u32 [ms], flags u8 (bit 0: coded), texels`: plain, one u16 a cell, all
matrices in order, index y * cells_x + x; coded, u16 units with the count in bits 15-12 and the value in
bits 11-0.  Frames are pushed between replies.  The pitch comes from the array itself (id 0B).
"""

import struct
from dataclasses import dataclass

import numpy as np

from exploration.devices.wire.stream import Cut, RawFrame
from exploration.devices.wire.weiss_packets import DSA, Framing, packet, packets
from primitives.arrays import Floats, Ints, frozen

BAUD = 115200
FRAME, CONTROLLER_INFO, SENSOR_INFO, CONFIGURE, STATE, MATRIX_INFO = 0x00, 0x01, 0x02, 0x03, 0x0A, 0x0B
_HEAD = struct.Struct("<IB")
_MATRIX = struct.Struct("<HffHH6s2sB6ffB")
_LONGEST_RUN = 15
_OTHER_REPLIES = 64  # bytes of any payload that is no frame


@dataclass(frozen=True)
class MatrixInfo:
    """What the array says of one of its matrices."""

    pitch: tuple[float, float]  # (x, y) [mm]
    cells: tuple[int, int]  # (x, y)
    full_scale: float  # counts


def configure(running: bool, coded: bool = True, rate: int = 30) -> bytes:
    """Start or stop pushing frames, at most 30 a second."""
    return packet(
        CONFIGURE, struct.pack("<BH", (0x80 if running else 0) | (running and coded), rate if running else 0)
    )


def ask_matrix(index: int = 0) -> bytes:
    """Ask for what `matrix_info` reads."""
    return packet(MATRIX_INFO, bytes([index]))


def matrix_info(payload: bytes) -> MatrixInfo | None:
    """A reply to `ask_matrix`; None where it is an error, or not one."""
    if len(payload) < 51:
        return None
    error, width, height, x, y = struct.unpack_from("<HffHH", payload)
    (full,) = struct.unpack_from("<f", payload, 47)
    if error or not (0.01 < width < 1000.0 and 0.01 < height < 1000.0 and x and y):
        return None
    return MatrixInfo((width, height), (x, y), full)


def encode_matrix_info(told: MatrixInfo) -> bytes:
    """The reply, as the array sends it."""
    fields = (0, *told.pitch, *told.cells, b"", b"", 0, *(0.0,) * 6, told.full_scale, 0)
    return packet(MATRIX_INFO, _MATRIX.pack(*fields))


def run_lengths(values: Ints) -> bytes:
    """(n,) values below 4096 as units of a count and a value."""
    starts = np.flatnonzero(np.diff(values, prepend=-1))
    units: list[int] = []
    for value, length in zip(values[starts].tolist(), np.diff([*starts, len(values)]).tolist(), strict=True):
        while length > 0:
            units.append(min(length, _LONGEST_RUN) << 12 | value)
            length -= _LONGEST_RUN
    return np.array(units, "<u2").tobytes()


def texels(payload: bytes, cells: int) -> Floats | None:
    """(cells,) counts of a frame's payload, or None where it holds another number of them."""
    if len(payload) < _HEAD.size or (len(payload) - _HEAD.size) % 2:
        return None
    values = np.frombuffer(payload, "<u2", offset=_HEAD.size)
    if payload[4] & 1:
        counts = values >> 12
        if int(counts.sum()) != cells:
            return None
        values = np.repeat(values & 0x0FFF, counts)
    return frozen(values.astype(np.float64)) if len(values) == cells else None


def encode_frame(counts: Ints, milliseconds: int, coded: bool = True, framing: Framing = DSA) -> bytes:
    """A frame as the array sends it."""
    values = np.asarray(counts).ravel()
    body = run_lengths(values) if coded else values.astype("<u2").tobytes()
    return packet(FRAME, _HEAD.pack(milliseconds & 0xFFFFFFFF, int(coded)) + body, framing)


def cut_weiss(buffer: bytes, cells: int, framing: Framing, ids: tuple[int, ...]) -> Cut:
    """Frames and replies of either family."""
    largest = max(_OTHER_REPLIES, _HEAD.size + 2 * cells)
    found, rest, skipped = packets(buffer, framing, largest)
    frames, replies = [], []
    for reply in found:
        if reply.id not in ids:
            replies.append(reply)
        elif (counts := texels(reply.payload, cells)) is not None:
            frames.append(RawFrame(counts, _HEAD.unpack_from(reply.payload)[0] / 1000.0))
        else:
            skipped += len(reply.payload) + 8
    return Cut(tuple(frames), rest, skipped, tuple(replies))


def cut(buffer: bytes, cells: int) -> Cut:
    """Frames of `cells` cells in a buffer."""
    return cut_weiss(buffer, cells, DSA, (FRAME,))
