"""Weiss Robotics' framing: `AA AA AA | id u8 | size u16 | payload | CRC u16`, little-endian.

The CRC takes the table of the polynomial 0x1021 (most significant bit first) but shifts right, ``crc =
(crc >> 8) ^ T[(crc ^ byte) & 0xFF]`` from 0xFFFF, so it is not CCITT-FALSE: "123456789" gives 0x6EB4,
and data followed by its CRC give 0.  A DSA's CRC covers id, size and payload, and a packet without
payload has none; a WTS's covers the preamble too and is always there.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from exploration.devices.wire.stream import Reply

PREAMBLE = b"\xaa\xaa\xaa"
HEAD = 6  # bytes before the payload


def _table() -> tuple[int, ...]:
    table = []
    for index in range(256):
        crc = index << 8
        for _ in range(8):
            crc = ((crc << 1) ^ 0x1021 if crc & 0x8000 else crc << 1) & 0xFFFF
        table.append(crc)
    return tuple(table)


_T = _table()


def crc16(data: bytes, crc: int = 0xFFFF) -> int:
    """The CRC of some bytes."""
    for byte in data:
        crc = (crc >> 8) ^ _T[(crc ^ byte) & 0xFF]
    return crc


@dataclass(frozen=True)
class Framing:
    """What the two families of arrays do differently."""

    preamble_counts: bool = False  # in the CRC
    always: bool = False  # a CRC even without payload

    def crc(self, id_: int, payload: bytes) -> int:
        """Of a packet."""
        head = bytes([id_]) + len(payload).to_bytes(2, "little")
        return crc16((PREAMBLE if self.preamble_counts else b"") + head + payload)


DSA = Framing()
WTS = Framing(preamble_counts=True, always=True)


def packet(id_: int, payload: bytes = b"", framing: Framing = DSA) -> bytes:
    """The bytes of a packet."""
    body = PREAMBLE + bytes([id_]) + len(payload).to_bytes(2, "little") + payload
    if payload or framing.always:
        body += framing.crc(id_, payload).to_bytes(2, "little")
    return body


def packets(buffer: bytes, framing: Framing, largest: int) -> tuple[list[Reply], bytes, int]:
    """The whole packets in a buffer, what waits for more, and how many bytes were skipped.

    A head whose payload is not there yet waits, but a whole packet behind it proves that it was none.
    """
    found: list[Reply] = []
    at, used, waiting = 0, 0, -1
    while (start := buffer.find(PREAMBLE, at)) >= 0:
        if start + HEAD > len(buffer):
            waiting = start if waiting < 0 else waiting
            break
        size = buffer[start + 4] | buffer[start + 5] << 8
        end = start + HEAD + size + (2 if size or framing.always else 0)
        at = start + 1
        if size > largest:
            continue
        if end > len(buffer):
            waiting = start if waiting < 0 else waiting
            continue
        payload = buffer[start + HEAD : start + HEAD + size]
        if end > start + HEAD + size and framing.crc(buffer[start + 3], payload) != (
            buffer[end - 2] | buffer[end - 1] << 8
        ):
            continue
        found.append(Reply(buffer[start + 3], payload))
        at, waiting = end, -1
        used += end - start
    rest = buffer[waiting:] if waiting >= 0 else buffer[max(at, len(buffer) - _tail(buffer)) :]
    return found, rest, len(buffer) - len(rest) - used


def _tail(buffer: bytes) -> int:
    """How many bytes at the end may begin a preamble."""
    return next((n for n in (2, 1) if buffer.endswith(PREAMBLE[:n])), 0)


def only(replies: Sequence[Reply], id_: int) -> bytes | None:
    """The payload of the newest reply of an id."""
    return next((reply.payload for reply in reversed(replies) if reply.id == id_), None)
