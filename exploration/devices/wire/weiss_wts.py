"""Weiss WTS and WTS-FT: the DSA's framing with a CRC that covers the preamble and is always there.

20 asks for one frame, 21 starts them (flags u8, delay u16 [ms]), 22 stops them, 23 tares, 30 tells the
matrix (status u16, cells x and y u16, cell width and height u16 in 1/100 mm, full scale u16).  A frame
is the DSA's.
"""

import struct

from exploration.devices.wire.stream import Cut
from exploration.devices.wire.weiss_dsa import MatrixInfo, cut_weiss, encode_frame
from exploration.devices.wire.weiss_packets import WTS, packet
from primitives.arrays import Ints

BAUD = 115200
FRAME, SINGLE, START, STOP, TARE, MATRIX_INFO = 0x00, 0x20, 0x21, 0x22, 0x23, 0x30
_MATRIX = struct.Struct("<6H")


def start(delay_ms: int, coded: bool = False) -> bytes:
    """Push a frame every `delay_ms`."""
    return packet(START, struct.pack("<BH", int(coded), delay_ms), WTS)


def stop() -> bytes:
    """Push no more."""
    return packet(STOP, b"", WTS)


def ask_matrix() -> bytes:
    """Ask for what `matrix_info` reads."""
    return packet(MATRIX_INFO, b"", WTS)


def matrix_info(payload: bytes) -> MatrixInfo | None:
    """A reply to `ask_matrix`; None where it is an error, or not one."""
    if len(payload) < _MATRIX.size:
        return None
    status, x, y, width, height, full = _MATRIX.unpack_from(payload)
    if status or not (x and y and width and height):
        return None
    return MatrixInfo((width / 100.0, height / 100.0), (x, y), float(full))


def encode_matrix_info(told: MatrixInfo) -> bytes:
    """The reply, as the array sends it."""
    pitch = (round(100 * told.pitch[0]), round(100 * told.pitch[1]))
    return packet(MATRIX_INFO, _MATRIX.pack(0, *told.cells, *pitch, int(told.full_scale)), WTS)


def encode(counts: Ints, milliseconds: int, coded: bool = False) -> bytes:
    """A frame as the array sends it."""
    return encode_frame(counts, milliseconds, coded, WTS)


def cut(buffer: bytes, cells: int) -> Cut:
    """Frames of `cells` cells in a buffer."""
    return cut_weiss(buffer, cells, WTS, (FRAME, SINGLE))
