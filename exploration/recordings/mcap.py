"""An episode on disk: every frame, pose, wrench and event, in order, as one MCAP file.

Each message is JSON under a JSON schema, so that Foxglove opens the file without our code:

| topic          | schema                  | content                                                       |
|----------------|-------------------------|---------------------------------------------------------------|
| `/NAME/taxels` | foxglove.RawImage       | counts, base64; `mono16` where they are whole, else `32FC1`   |
| `/NAME/pose`   | foxglove.FrameTransform | world_from_sensor, in meters and xyzw as that schema asks     |
| `/NAME/wrench` | palpate.Wrench          | force [N] and torque [N mm] on the pad, in the sensor's frame |
| `/events`      | palpate.Event           | what happened (`kind`) and its `detail`                       |

The three messages of a frame share time and sequence (the frame's index).  Chunks are small and are handed to
the operating system as they fill, so a file that a kill or a full disk cut short reads up to its last whole
chunk.  Encoding waits in batches, which keeps it out of the servo's tick.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO

import numpy as np
from mcap.records import Channel, Chunk, Message
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import CompressionType, Writer

from exploration.recordings.schemas import SCHEMAS
from exploration.sensing.frame import TaxelFrame
from primitives.arrays import Floats, frozen
from primitives.errors import NotWritten, PalpateError
from primitives.pose import from_quaternion, quaternion_wxyz

_CHUNK_BYTES = 64 * 1024
_BATCH = 32  # frames that wait for their encoding
_LARGEST_RECORD = 1 << 28  # [bytes] of a record, and of a chunk once it is inflated
_MAGIC = b"\x89MCAP0\r\n"
_EVENTS = "/events"


@dataclass(frozen=True)
class RecordedFrame:
    """One frame of one array as it was recorded."""

    sensor: str
    frame: TaxelFrame
    world_from_sensor: Floats  # (4, 4)
    wrench: Floats  # (6,) force [N], torque [N mm] in the sensor's frame


@dataclass(frozen=True)
class RecordedEvent:
    """One thing that happened."""

    time: float  # [s]
    kind: str
    detail: Mapping[str, Any]


class Recorder:
    """Writes an episode; a context manager, whole once it is closed."""

    def __init__(self, path: Path) -> None:
        self._path = path
        with self._refusing_bad_disks():
            self._file: BinaryIO = path.open("wb")
        self._writer = Writer(self._file, chunk_size=_CHUNK_BYTES, compression=CompressionType.ZSTD)
        self._writer.start(profile="", library="palpate")
        self._schemas = {
            name: self._writer.register_schema(name, "jsonschema", json.dumps(schema).encode())
            for name, schema in SCHEMAS.items()
        }
        self._channels: dict[str, int] = {}
        self._waiting: list[tuple[str, float, int, Floats, Floats, Floats]] = []

    def frame(self, sensor: str, frame: TaxelFrame, world_from_sensor: Floats, wrench: Floats) -> None:
        """Record one reading with where the array was and what pressed on it."""
        self._waiting.append(
            (sensor, frame.time, frame.index, frame.counts.copy(), world_from_sensor.copy(), wrench.copy())
        )
        if len(self._waiting) >= _BATCH:
            with self._refusing_bad_disks():
                self._encode()

    def event(self, time: float, kind: str, detail: Mapping[str, Any] | None = None) -> None:
        """Record that something happened at `time` [s]; `detail` is anything JSON can say."""
        stamp, nanoseconds = _stamp(time)
        body = json.dumps({"kind": kind, "detail": dict(detail or {})}, default=_plain)
        with self._refusing_bad_disks():
            self._encode()
            self._add(_EVENTS, "palpate.Event", f'{{"timestamp":{stamp},{body[1:]}', nanoseconds, 0)

    def close(self) -> None:
        """Write what waits, and the index."""
        if not self._file.closed:
            with self._refusing_bad_disks(), self._file:
                self._encode()
                self._writer.finish()

    def _encode(self) -> None:
        if not self._waiting:
            return
        poses = np.stack([waiting[4] for waiting in self._waiting])
        turns = quaternion_wxyz(poses).tolist()
        places = (poses[:, :3, 3] / 1000.0).tolist()
        for (sensor, seconds, index, counts, _, wrench), (w, x, y, z), (px, py, pz) in zip(
            self._waiting, turns, places, strict=True
        ):
            stamp, time = _stamp(seconds)
            rows, columns = counts.shape
            encoding, data = _pixels(counts)
            step = len(data) // rows
            image = (
                f'{{"timestamp":{stamp},"frame_id":"{sensor}","width":{columns},"height":{rows},'
                f'"encoding":"{encoding}","step":{step},"data":"{base64.b64encode(data).decode()}"}}'
            )
            transform = (
                f'{{"timestamp":{stamp},"parent_frame_id":"world","child_frame_id":"{sensor}",'
                f'"translation":{{"x":{px:.10g},"y":{py:.10g},"z":{pz:.10g}}},'
                f'"rotation":{{"x":{x:.12g},"y":{y:.12g},"z":{z:.12g},"w":{w:.12g}}}}}'
            )
            fx, fy, fz, tx, ty, tz = wrench.tolist()
            push = (
                f'{{"timestamp":{stamp},"force":{{"x":{fx:.9g},"y":{fy:.9g},"z":{fz:.9g}}},'
                f'"torque":{{"x":{tx:.9g},"y":{ty:.9g},"z":{tz:.9g}}}}}'
            )
            self._add(f"/{sensor}/taxels", "foxglove.RawImage", image, time, index)
            self._add(f"/{sensor}/pose", "foxglove.FrameTransform", transform, time, index)
            self._add(f"/{sensor}/wrench", "palpate.Wrench", push, time, index)
        self._waiting.clear()
        self._file.flush()

    def _add(self, topic: str, schema: str, body: str, time: int, sequence: int) -> None:
        channel = self._channels.get(topic)
        if channel is None:
            channel = self._writer.register_channel(topic, "json", self._schemas[schema])
            self._channels[topic] = channel
        self._writer.add_message(channel, time, body.encode(), time, sequence)

    @contextmanager
    def _refusing_bad_disks(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            reason = error.strerror or str(error)
            raise NotWritten(f"cannot write {self._path} ({reason}); choose another folder") from error

    def __enter__(self) -> Recorder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def read(path: Path) -> Iterator[RecordedFrame | RecordedEvent]:
    """Everything whole in a recording, in order; one that was cut short just ends sooner."""
    try:
        with path.open("rb") as file:
            magic = file.read(len(_MAGIC))
            if not _MAGIC.startswith(magic):
                raise PalpateError(f"{path} is not an MCAP recording; give an episode.mcap")
            file.seek(0)
            yield from _items(file)
    except OSError as error:
        raise PalpateError(f"cannot read {path}: {error.strerror or error}") from error


def _items(file: BinaryIO) -> Iterator[RecordedFrame | RecordedEvent]:
    topics: dict[int, str] = {}
    parts: dict[tuple[str, int, int], dict[str, Any]] = {}
    for record in _whole_records(file):
        if isinstance(record, Channel):
            topics[record.id] = record.topic
        elif isinstance(record, Message):
            topic = topics[record.channel_id]
            body = json.loads(record.data)
            if topic == _EVENTS:
                yield RecordedEvent(record.log_time / 1e9, body["kind"], body["detail"])
                continue
            _, sensor, part = topic.split("/")
            key = (sensor, record.sequence, record.log_time)
            found = parts.setdefault(key, {})
            found[part] = body
            if len(found) == 3:
                yield _assembled(key, parts.pop(key))


def _whole_records(file: BinaryIO) -> Iterator[object]:
    reader = StreamReader(file, emit_chunks=True, validate_crcs=True, record_size_limit=_LARGEST_RECORD)
    records = iter(reader.records)
    while True:
        try:
            record = next(records)
            chunk = isinstance(record, Chunk) and record.uncompressed_size <= _LARGEST_RECORD
            inside = breakup_chunk(record, validate_crc=True) if chunk else [record]
        except Exception:  # what a cut or damaged tail makes the parser raise has no one type
            return
        yield from inside


def _assembled(key: tuple[str, int, int], found: Mapping[str, Any]) -> RecordedFrame:
    sensor, index, time = key
    image, transform, push = found["taxels"], found["pose"], found["wrench"]
    kind = np.dtype("<u2") if image["encoding"] == "mono16" else np.dtype("<f4")
    counts = np.frombuffer(base64.b64decode(image["data"]), kind).reshape(image["height"], image["width"])
    turn, place = transform["rotation"], transform["translation"]
    pose = from_quaternion(
        [turn["w"], turn["x"], turn["y"], turn["z"]], [1000.0 * place[axis] for axis in "xyz"]
    )
    wrench = [push[part][axis] for part in ("force", "torque") for axis in "xyz"]
    return RecordedFrame(sensor, TaxelFrame(frozen(counts), time / 1e9, index), frozen(pose), frozen(wrench))


def _pixels(counts: Floats) -> tuple[str, bytes]:
    whole = counts.astype("<u2")
    if np.array_equal(whole, counts):
        return "mono16", whole.tobytes()
    return "32FC1", counts.astype("<f4").tobytes()


def _stamp(time: float) -> tuple[str, int]:
    nanoseconds = round(time * 1e9)
    return f'{{"sec":{nanoseconds // 1_000_000_000},"nsec":{nanoseconds % 1_000_000_000}}}', nanoseconds


def _plain(value: object) -> object:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"an event's detail cannot hold {type(value).__name__}")
