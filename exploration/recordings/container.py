"""The MCAP container (mcap.dev): a stream of messages in compressed, checked chunks, and an index behind them.

A chunk goes to the operating system as soon as it is full, so a file that a kill or a full disk cut short reads up
to its last whole chunk.  Records are the `mcap` package's; but the messages of a chunk, of which a recording has
hundreds a second, are packed here.
"""

import os
import struct
import zlib
from collections.abc import Iterator, Mapping
from typing import BinaryIO

import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.reader import SeekingReader
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Message,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.stream_reader import StreamReader, breakup_chunk

MAGIC = b"\x89MCAP0\r\n"
CHUNK_BYTES = 64 * 1024
LEVEL = 1  # of compression: twice as fast as the usual, and as good on noise
LARGEST_RECORD = 1 << 28  # [bytes] of a record, and of a chunk once it is inflated
_MESSAGE = struct.Struct("<BQHIQQ")  # opcode, length, channel, sequence, log time, publish time
_INDEX = struct.Struct("<BQHI")  # opcode, length, channel, bytes of entries
_TAIL = struct.Struct("<QQI8s")  # start of the summary, of its offsets, checksum, magic
_SUMMARY = struct.Struct("<BQQQ")  # opcode, length, start, offset start


class Writer:
    """Writes messages to an open file; whole once it is finished."""

    def __init__(self, file: BinaryIO, schemas: Mapping[str, bytes]) -> None:
        """`schemas` are JSON schemas by name."""
        self._file = file
        self._compressor = zstandard.ZstdCompressor(level=LEVEL)
        self._schemas = [
            Schema(id=i, name=name, encoding="jsonschema", data=data)
            for i, (name, data) in enumerate(schemas.items(), 1)
        ]
        self._channels: dict[str, Channel] = {}
        self._counts: dict[int, int] = {}  # messages of each channel
        self._span: tuple[int, int] | None = None  # [ns] of all messages
        self._chunks: list[ChunkIndex] = []
        self._parts: list[bytes] = []  # of the chunk under way
        self._size = 0
        self._entries: dict[int, list[int]] = {}  # of each channel: time and offset of each message in it
        self._file.write(MAGIC)
        self._put(Header(profile="", library="palpate"), *self._schemas)

    def channel(self, topic: str, schema: str) -> int:
        """The number of a topic of JSON messages."""
        known = self._channels.get(topic)
        if known is None:
            which = next(s.id for s in self._schemas if s.name == schema)
            known = Channel(len(self._channels) + 1, topic, "json", {}, which)
            self._channels[topic] = known
            self._counts[known.id] = 0
            self._put(known)
        return int(known.id)

    def add(self, channel: int, time: int, sequence: int, body: bytes) -> None:
        """One message at `time` [ns]."""
        entries = self._entries.setdefault(channel, [])
        entries += time, self._size
        self._parts += _MESSAGE.pack(Opcode.MESSAGE, 22 + len(body), channel, sequence, time, time), body
        self._size += _MESSAGE.size + len(body)
        if self._size > CHUNK_BYTES:
            self._end_chunk()

    def finish(self) -> None:
        """Write what waits, and the index."""
        self._end_chunk()
        self._put(DataEnd(0))
        start, offsets = self._file.tell(), []
        groups = (
            (Opcode.SCHEMA, self._schemas),
            (Opcode.CHANNEL, list(self._channels.values())),
            (Opcode.STATISTICS, [self._statistics()]),
            (Opcode.CHUNK_INDEX, self._chunks),
        )
        crc = 0
        for opcode, records in groups:
            if records:
                at = self._file.tell()
                crc = zlib.crc32(self._put(*records), crc)
                offsets.append(SummaryOffset(opcode, at, self._file.tell() - at))
        at = self._file.tell()
        crc = zlib.crc32(self._put(*offsets), crc)
        crc = zlib.crc32(_SUMMARY.pack(Opcode.FOOTER, 20, start, at), crc)
        self._put(Footer(start, at, crc))
        self._file.write(MAGIC)

    def _end_chunk(self) -> None:
        if not self._size:
            return
        times = [time for entries in self._entries.values() for time in entries[::2]]
        first, last = min(times), max(times)
        data = b"".join(self._parts)
        packed = self._compressor.compress(data)
        start = self._file.tell()
        self._put(Chunk("zstd", packed, last, first, zlib.crc32(data), len(data)))
        length = self._file.tell() - start
        offsets, index = {}, []
        at = start + length
        for channel, entries in self._entries.items():
            offsets[channel] = at
            size = 8 * len(entries)
            index.append(_INDEX.pack(Opcode.MESSAGE_INDEX, 6 + size, channel, size))
            index.append(struct.pack(f"<{len(entries)}Q", *entries))
            at += _INDEX.size + size
            self._counts[channel] += len(entries) // 2
        self._file.write(b"".join(index))
        self._file.flush()
        self._chunks.append(
            ChunkIndex(
                chunk_start_offset=start,
                chunk_length=length,
                compression="zstd",
                compressed_size=len(packed),
                uncompressed_size=len(data),
                message_start_time=first,
                message_end_time=last,
                message_index_length=at - start - length,
                message_index_offsets=offsets,
            )
        )
        span = self._span or (first, last)
        self._span = min(first, span[0]), max(last, span[1])
        self._parts, self._size, self._entries = [], 0, {}

    def _statistics(self) -> Statistics:
        first, last = self._span or (0, 0)
        return Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts=self._counts,
            chunk_count=len(self._chunks),
            message_count=sum(self._counts.values()),
            message_end_time=last,
            message_start_time=first,
            metadata_count=0,
            schema_count=len(self._schemas),
        )

    def _put(self, *records: McapRecord) -> bytes:
        builder = RecordBuilder()
        for record in records:
            record.write(builder)
        data: bytes = builder.end()
        self._file.write(data)
        return data


def messages(file: BinaryIO) -> Iterator[tuple[str, Message]]:
    """Topic and message of everything whole in a file, in order; one that was cut short just ends sooner."""
    topics: dict[int, str] = {}
    for record in _whole_records(file):
        if isinstance(record, Channel):
            topics[record.id] = record.topic
        elif isinstance(record, Message):
            yield topics[record.channel_id], record


def topics_at_end(file: BinaryIO) -> tuple[str, ...]:
    """The topics that hold messages, each once, as a whole summary at the end tells; else none."""
    if not _summary_is_whole(file):
        return ()
    file.seek(0)
    try:
        summary = SeekingReader(file).get_summary()
    except Exception:  # as of a damaged tail in what follows
        return ()
    if summary is None or summary.statistics is None:
        return ()
    counts = summary.statistics.channel_message_counts
    held = [summary.channels.get(key) for key in sorted(counts) if counts[key]]
    known = [channel.topic for channel in held if channel is not None]
    return tuple(dict.fromkeys(known)) if len(known) == len(held) else ()


def _summary_is_whole(file: BinaryIO) -> bool:
    """Whether a file ends with a summary whose checksum is right."""
    size = file.seek(0, os.SEEK_END)
    file.seek(max(0, size - _TAIL.size))
    tail = file.read(_TAIL.size)
    if len(tail) < _TAIL.size:
        return False
    start, _, checksum, magic = _TAIL.unpack(tail)
    if magic != MAGIC or not 0 < start < size:
        return False
    file.seek(start)
    return bool(zlib.crc32(file.read(size - start - len(MAGIC) - 4)) == checksum)


def _whole_records(file: BinaryIO) -> Iterator[McapRecord]:
    reader = StreamReader(file, emit_chunks=True, validate_crcs=True, record_size_limit=LARGEST_RECORD)
    records = iter(reader.records)
    while True:
        try:
            record = next(records)
            chunk = isinstance(record, Chunk) and record.uncompressed_size <= LARGEST_RECORD
            inside = breakup_chunk(record, validate_crc=True) if chunk else [record]
        except Exception:  # what a cut or damaged tail makes the parser raise has no one type
            return
        yield from inside
