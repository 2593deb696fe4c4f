"""`.npy` and `.npz` stacks of any array: (frames, rows, columns) and the layouts that `layout` knows.

An `.npy` is one stack, read from disk as it is needed.  An `.npz` holds one under any name (`frames`, `counts`,
`taxels`, `pressure` or `data` where there are several), and may hold `time` in seconds (or `time_ms`) and `poses`,
(frames, 4, 4) world_from_sensor in mm.  Its members are read frame by frame as they inflate.  Pickled objects are
refused: they would run code.
"""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, Literal

import numpy as np

from exploration.recordings.intake import LARGEST, inflated_too_far, opened
from exploration.recordings.layout import Layout, layout_of, plain_warnings
from exploration.recordings.recording import PadFrame, Recording
from exploration.sensing.frame import TaxelFrame
from exploration.sensing.spec import SensorSpec
from primitives.arrays import Floats, frozen
from primitives.errors import PalpateError

STACKS = ("frames", "counts", "taxels", "pressure", "data")
TIMES = {"time": 1.0, "times": 1.0, "t": 1.0, "timestamps": 1.0, "time_s": 1.0, "time_ms": 1e-3}
POSES = ("poses", "world_from_sensor")
_SMALL = 1 << 28  # [bytes] of a time or pose array, and of a stack in Fortran order


@dataclass(frozen=True)
class _Header:
    shape: tuple[int, ...]
    fortran: bool
    dtype: np.dtype[Any]

    @property
    def bytes(self) -> int:
        size = self.dtype.itemsize
        for length in self.shape:
            size *= length
        return size


def read_npy(path: Path, spec: SensorSpec | None = None) -> Recording:
    """A stack in an .npy file."""
    with _refusing(path), opened(path) as file:
        header = _header(str(path), file)
        if header.bytes > path.stat().st_size - file.tell():
            raise PalpateError(f"{path} is cut short: {_times(header)} values are announced; copy it again")
        start = file.tell()
    layout = layout_of(str(path), header.shape, spec, _full_scale(header))

    def replay() -> Iterator[PadFrame]:
        order: Literal["C", "F"] = "F" if header.fortran else "C"
        with _refusing(path):
            stack = np.memmap(path, header.dtype, "r", start, header.shape, order)
        for i, values in enumerate(stack.reshape(layout.shape)):
            yield from _pad_frames(i, values)

    return _recording(path, layout, replay, timed=False, posed=False)


def read_npz(path: Path, spec: SensorSpec | None = None) -> Recording:
    """A stack in an .npz archive, with times and poses where it has them."""
    with _refusing(path), opened(path) as file, zipfile.ZipFile(file) as archive:
        headers = _headers(path, archive)
        name = _the_stack(path, headers)
        layout = layout_of(f"{path}: {name}", headers[name].shape, spec, _full_scale(headers[name]))
        times = _times_in(path, archive, headers, layout.frames)
        poses = _poses_in(path, archive, headers, layout.frames)
    header = headers[name]

    def replay() -> Iterator[PadFrame]:
        with _refusing(path), opened(path) as file, zipfile.ZipFile(file) as archive:
            for i, values in enumerate(_streamed(path, archive, name, header, layout)):
                time = np.nan if times is None else float(times[i])
                yield from _pad_frames(i, values, time, None if poses is None else poses[i])

    return _recording(path, layout, replay, times is not None, poses is not None)


def _recording(path: Path, layout: Layout, replay: Any, timed: bool, posed: bool) -> Recording:
    told = (*layout.assumed, *plain_warnings(layout.pads, timed, posed))
    pad = layout.pads[0]
    sensor = pad.spec.name if pad.spec else f"{pad.array.rows}x{pad.array.columns}"
    return Recording(path, sensor, layout.pads, replay, timed, posed, told)


def _pad_frames(
    index: int, values: Any, time: float = np.nan, pose: Floats | None = None
) -> Iterator[PadFrame]:
    for pad, counts in enumerate(values):
        yield PadFrame(pad, TaxelFrame(frozen(np.asarray(counts, dtype=np.float64)), time, index), pose)


def _header(where: str, file: IO[bytes]) -> _Header:
    """The header of .npy data; leaves the file at its first value."""
    try:
        version = np.lib.format.read_magic(file)
        read = (
            np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        )
        shape, fortran, dtype = read(file)
    except (ValueError, OverflowError, SyntaxError, TypeError) as error:
        raise PalpateError(f"{where} has no readable .npy header; save it again with numpy.save") from error
    if dtype.hasobject:
        raise PalpateError(f"{where} holds pickled objects, which could run code; save plain numbers instead")
    if dtype.kind not in "biuf":
        raise PalpateError(f"{where} holds {dtype}, not real numbers; save counts as integers or floats")
    if any(length < 0 for length in shape):
        raise PalpateError(f"{where} has shape {shape}; save it again with numpy.save")
    return _Header(tuple(shape), bool(fortran), dtype)


def _headers(path: Path, archive: zipfile.ZipFile) -> dict[str, _Header]:
    found = {}
    for info in archive.infolist()[:256]:
        if not info.filename.endswith(".npy"):
            continue
        if info.file_size > LARGEST:
            raise inflated_too_far(path)
        with archive.open(info) as member:
            header = _header(f"{path}: {info.filename}", member)
            if header.bytes > info.file_size - member.tell():
                raise PalpateError(f"{path}: {info.filename} is cut short; save it again")
        found[info.filename.removesuffix(".npy")] = header
    return found


def _the_stack(path: Path, headers: Mapping[str, _Header]) -> str:
    """The member that holds the frames."""
    stacks = [
        name for name in headers if name not in TIMES and name not in POSES and len(headers[name].shape) > 1
    ]
    named = [name for name in STACKS if name in stacks]
    if named:
        return named[0]
    if len(stacks) == 1:
        return stacks[0]
    held = ", ".join(f"{name} ({_times(header)})" for name, header in headers.items()) or "no array"
    raise PalpateError(f"{path} holds {held[:200]}; call the stack of frames `frames`")


def _times_in(
    path: Path, archive: zipfile.ZipFile, headers: Mapping[str, _Header], frames: int
) -> Floats | None:
    name = next((name for name in TIMES if name in headers), None)
    if name is None:
        return None
    times: Floats = _whole(path, archive, name, headers[name]).astype(np.float64) * TIMES[name]
    if times.shape != (frames,) or not np.isfinite(times).all() or (np.diff(times) < 0).any():
        raise PalpateError(
            f"{path}: {name} must be {frames} times that do not fall, one a frame; leave it out"
        )
    return frozen(times - times[0])


def _poses_in(
    path: Path, archive: zipfile.ZipFile, headers: Mapping[str, _Header], frames: int
) -> Floats | None:
    name = next((name for name in POSES if name in headers), None)
    if name is None:
        return None
    poses = _whole(path, archive, name, headers[name]).astype(np.float64)
    turns = poses[:, :3, :3] if poses.shape == (frames, 4, 4) else None
    if turns is None or not np.allclose(turns @ turns.swapaxes(1, 2), np.eye(3), atol=1e-4):
        raise PalpateError(f"{path}: {name} must be ({frames}, 4, 4) rigid motions in mm; leave it out")
    return frozen(poses)


def _whole(path: Path, archive: zipfile.ZipFile, name: str, header: _Header) -> Any:
    if header.bytes > _SMALL:
        raise PalpateError(f"{path}: {name} is larger than {_SMALL >> 20} MB; save it in C order, in pieces")
    with archive.open(f"{name}.npy") as member:
        _header(f"{path}: {name}", member)
        values = np.frombuffer(member.read(header.bytes), header.dtype)
        return values.reshape(header.shape, order="F" if header.fortran else "C")


def _streamed(
    path: Path, archive: zipfile.ZipFile, name: str, header: _Header, layout: Layout
) -> Iterator[Any]:
    """(pads, rows, columns) frame after frame."""
    if header.fortran:
        yield from _whole(path, archive, name, header).reshape(layout.shape)
        return
    one = layout.shape[1:]
    size = int(np.prod(one)) * header.dtype.itemsize
    with archive.open(f"{name}.npy") as member:
        _header(f"{path}: {name}", member)
        for _ in range(layout.frames):
            yield np.frombuffer(member.read(size), header.dtype).reshape(one)


def _full_scale(header: _Header) -> float:
    """[counts] the largest that a whole-number type of 8 or 16 bits can say."""
    small = header.dtype.kind in "iu" and header.dtype.itemsize <= 2
    return float(np.iinfo(header.dtype).max) if small else np.inf


@contextmanager
def _refusing(path: Path) -> Iterator[None]:
    """Damage of the archive as an error that names the fix."""
    try:
        yield
    except (zipfile.BadZipFile, zlib.error, EOFError, KeyError, NotImplementedError, RuntimeError) as error:
        raise PalpateError(
            f"{path} is damaged or no plain .npz archive; save it again with numpy.savez"
        ) from error
    except (OSError, ValueError) as error:
        raise PalpateError(f"{path} cannot be read to its end; save it again") from error


def _times(header: _Header) -> str:
    return " x ".join(map(str, header.shape))
