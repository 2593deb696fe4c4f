"""An episode on disk: every frame, pose, wrench and event, in order, as one MCAP file.

Each message is JSON under a JSON schema, so that Foxglove opens the file without our code:

| topic          | schema                  | content                                                       |
|----------------|-------------------------|---------------------------------------------------------------|
| `/NAME/taxels` | foxglove.RawImage       | counts, base64; `mono16` where they are whole, else `32FC1`   |
| `/NAME/pose`   | foxglove.FrameTransform | world_from_sensor, in meters and xyzw as that schema asks     |
| `/NAME/wrench` | palpate.Wrench          | force [N] and torque [N mm] on the pad, in the sensor's frame |
| `/events`      | palpate.Event           | what happened (`kind`) and its `detail`                       |
| `/log`         | foxglove.Log            | the same as lines to read                                     |
| `/scene`       | foxglove.SceneUpdate    | each pad, once, as a body in its own frame                    |

The three messages of a frame share time and sequence (the frame's index).  Encoding waits in batches, which keeps
it out of the servo's tick.
"""

from __future__ import annotations

import base64
import json
from binascii import b2a_base64
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO

import numpy as np

from exploration.recordings.container import MAGIC, Writer, messages, topics_at_end
from exploration.recordings.scene import log_line, pad_scene
from exploration.recordings.schemas import SCHEMAS
from exploration.sensing.frame import TaxelFrame
from primitives.arrays import Floats, frozen
from primitives.errors import NotWritten, PalpateError
from primitives.pose import from_quaternion, quaternion_wxyz

_BATCH = 64  # frames of one array that wait for their encoding
_SECOND = 1_000_000_000  # [ns]
_EVENTS, _LOG, _SCENE = "/events", "/log", "/scene"
_STAMP = b'{"timestamp":{"sec":%d,"nsec":%d},'
_IMAGE = b'"frame_id":"%s","width":%d,"height":%d,"encoding":"%s","step":%d,"data":"'
_TRANSFORM = (
    b'%s"parent_frame_id":"world","child_frame_id":"%s","translation":{"x":%.10g,"y":%.10g,"z":%.10g},'
    b'"rotation":{"w":%.12g,"x":%.12g,"y":%.12g,"z":%.12g}}'
)
_PUSH = b'%s"force":{"x":%.9g,"y":%.9g,"z":%.9g},"torque":{"x":%.9g,"y":%.9g,"z":%.9g}}'


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
            schemas = {name: json.dumps(schema).encode() for name, schema in SCHEMAS.items()}
            self._writer = Writer(self._file, schemas)
        self._source: tuple[str, tuple[int, ...]] = ("", ())  # name and shape of the frames that wait
        self._waiting: list[tuple[float, int, Floats, Floats, Floats]] = []

    def frame(self, sensor: str, frame: TaxelFrame, world_from_sensor: Floats, wrench: Floats) -> None:
        """Record one reading with where the array was and what pressed on it."""
        if len(self._waiting) >= _BATCH or self._source != (sensor, frame.counts.shape):
            with self._refusing_bad_disks():
                self._encode()
            self._source = (sensor, frame.counts.shape)
        self._waiting.append(
            (frame.time, frame.index, frozen(frame.counts), frozen(world_from_sensor), wrench.copy())
        )

    def pad(self, sensor: str, size: tuple[float, float], time: float) -> None:
        """Record how large an array is [mm], for those who draw it."""
        nanoseconds = round(time * _SECOND)
        with self._refusing_bad_disks():
            channel = self._writer.channel(_SCENE, "foxglove.SceneUpdate")
            self._writer.add(channel, nanoseconds, 0, pad_scene(sensor, size, nanoseconds))

    def event(self, time: float, kind: str, detail: Mapping[str, Any] | None = None) -> None:
        """Record that something happened at `time` [s]; `detail` is anything JSON can say."""
        body = json.dumps({"kind": kind, "detail": dict(detail or {})}, default=_plain)
        nanoseconds = round(time * _SECOND)
        with self._refusing_bad_disks():
            self._encode()
            channel = self._writer.channel(_EVENTS, "palpate.Event")
            self._writer.add(
                channel, nanoseconds, 0, _STAMP % divmod(nanoseconds, _SECOND) + body[1:].encode()
            )
            log = self._writer.channel(_LOG, "foxglove.Log")
            self._writer.add(log, nanoseconds, 0, log_line(kind, detail or {}, nanoseconds))

    def close(self) -> None:
        """Write what waits, and the index."""
        if not self._file.closed:
            with self._refusing_bad_disks(), self._file:
                self._encode()
                self._writer.finish()

    def _encode(self) -> None:
        if not self._waiting:
            return
        times, indices, counts, poses, wrenches = zip(*self._waiting, strict=True)
        self._waiting = []
        name, add = self._source[0], self._writer.add
        taxels, pose, wrench = (
            self._writer.channel(f"/{name}/{part}", schema)
            for part, schema in (
                ("taxels", "foxglove.RawImage"),
                ("pose", "foxglove.FrameTransform"),
                ("wrench", "palpate.Wrench"),
            )
        )
        encoding, pixels = _pixels(np.stack(counts))
        place = np.stack(poses)
        where = np.hstack([place[:, :3, 3] / 1000.0, quaternion_wxyz(place)]).tolist()
        rows, columns = counts[0].shape
        sensor = name.encode()
        head = _IMAGE % (sensor, columns, rows, encoding, len(pixels[0]) // rows)
        for seconds, index, data, at, push in zip(
            times, indices, pixels, where, np.stack(wrenches).tolist(), strict=True
        ):
            time = round(seconds * _SECOND)
            stamp = _STAMP % divmod(time, _SECOND)
            add(taxels, time, index, b'%s%s%s"}' % (stamp, head, b2a_base64(data, newline=False)))
            add(pose, time, index, _TRANSFORM % (stamp, sensor, *at))
            add(wrench, time, index, _PUSH % (stamp, *push))

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
    parts: dict[tuple[str, int, int], dict[str, Any]] = {}
    with _opened(path) as file:
        for topic, message in messages(file):
            if topic in (_LOG, _SCENE):
                continue
            if topic == _EVENTS:
                yield _event(message.log_time, message.data)
                continue
            _, sensor, part = topic.split("/")
            key = (sensor, message.sequence, message.log_time)
            found = parts.setdefault(key, {})
            found[part] = json.loads(message.data)
            if len(found) == 3:
                yield _assembled(key, parts.pop(key))


def events(path: Path) -> Iterator[RecordedEvent]:
    """What `read` gives without the frames, which are nearly all of a recording and are not decoded here."""
    with _opened(path) as file:
        for topic, message in messages(file):
            if topic == _EVENTS:
                yield _event(message.log_time, message.data)


def arrays(path: Path) -> tuple[str, ...]:
    """The names of all arrays that a recording holds frames of, each once."""
    with path.open("rb") as file:
        topics = topics_at_end(file)
        if not topics:
            file.seek(0)
            topics = tuple(topic for topic, _ in messages(file))
    return tuple(dict.fromkeys(topic.split("/")[1] for topic in topics if topic.endswith("/taxels")))


@contextmanager
def _opened(path: Path) -> Iterator[BinaryIO]:
    try:
        with path.open("rb") as file:
            magic = file.read(len(MAGIC))
            if not MAGIC.startswith(magic):
                raise PalpateError(f"{path} is not an MCAP recording; give an episode.mcap")
            file.seek(0)
            yield file
    except OSError as error:
        raise PalpateError(f"cannot read {path}: {error.strerror or error}") from error


def _event(time: int, data: bytes) -> RecordedEvent:
    body = json.loads(data)
    return RecordedEvent(time / 1e9, body["kind"], body["detail"])


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


def _pixels(counts: Floats) -> tuple[bytes, list[bytes]]:
    """Encoding and data of (n, rows, columns) frames."""
    with np.errstate(invalid="ignore"):
        whole = counts.astype("<u2")
    if np.array_equal(whole, counts):
        return b"mono16", [image.tobytes() for image in whole]
    return b"32FC1", [image.tobytes() for image in counts.astype("<f4")]


def _plain(value: object) -> object:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"an event's detail cannot hold {type(value).__name__}")
