"""Our own episodes read back as recordings: `mcap` files, with every frame's pose."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from exploration.recordings.intake import opened
from exploration.recordings.mcap import RecordedFrame, arrays, read
from exploration.recordings.recording import Pad, PadFrame, Recording
from exploration.sensing.frame import TaxelArray
from exploration.sensing.spec import SensorSpec, load_sensor, sensor_names
from primitives.arrays import frozen
from primitives.errors import PalpateError


def read_episode(path: Path, spec: SensorSpec | None = None) -> Recording:
    """An episode; `spec` describes its array, or of several the one it fits, where that is not a built-in one."""
    with opened(path):
        pass
    first: dict[str, RecordedFrame] = {}
    held = _arrays(path)
    for item in _frames(path):
        first.setdefault(item.sensor, item)
        if len(first) == len(held):
            break
    pads: dict[str, Pad] = {}
    for name, item in first.items():
        fits = spec is not None and (len(first) == 1 or spec.array.shape == item.frame.counts.shape)
        pads[name] = _pad(path, item, spec if fits else None)
    if not pads:
        raise PalpateError(f"{path} holds no frame of a taxel array; give the episode.mcap of a run")
    names = tuple(pads)

    def replay() -> Iterator[PadFrame]:
        count = [0] * len(names)
        for item in _frames(path):
            if item.sensor not in pads or item.frame.counts.shape != pads[item.sensor].array.shape:
                raise PalpateError(f"{path}: array {item.sensor} changes within the recording; split it")
            pad = names.index(item.sensor)
            yield PadFrame(pad, replace(item.frame, index=count[pad]), item.world_from_sensor)
            count[pad] += 1

    plain = [name for name, pad in pads.items() if pad.assumed_pitch]
    told = []
    if plain:
        told.append(
            f"{', '.join(plain)} is no built-in array: pitch 1, no force, no curvature; give --sensor"
        )
    if not _ends_whole(path):
        told.append("the recording was cut short; this is what is whole of it")
    return Recording(path, ",".join(names), tuple(pads.values()), replay, True, True, tuple(told))


def _arrays(path: Path) -> tuple[str, ...]:
    try:
        return arrays(path)
    except (KeyError, ValueError, IndexError):
        raise PalpateError(f"{path} holds messages of another kind; give the episode.mcap of a run") from None


def _ends_whole(path: Path) -> bool:
    with opened(path) as file:
        file.seek(-min(8, path.stat().st_size), 2)
        return file.read() == b"\x89MCAP0\r\n"


def _frames(path: Path) -> Iterator[RecordedFrame]:
    try:
        yield from (item for item in read(path) if isinstance(item, RecordedFrame))
    except (KeyError, ValueError, TypeError, RecursionError):
        raise PalpateError(f"{path} holds messages of another kind; give the episode.mcap of a run") from None


def _pad(path: Path, item: RecordedFrame, spec: SensorSpec | None) -> Pad:
    rows, columns = shape = item.frame.counts.shape
    known = spec or (load_sensor(item.sensor) if item.sensor in sensor_names() else None)
    if known is not None and known.array.shape != shape:
        if spec is not None:
            raise PalpateError(
                f"{path}: {item.sensor} is {shape[0]} x {shape[1]}, and {spec.name} is not: leave --sensor out"
            )
        known = None
    absent = frozen(np.zeros(shape), np.bool_)
    if known is None:
        return Pad(TaxelArray(item.sensor, rows, columns, (1.0, 1.0)), absent, assumed_pitch=True)
    array = replace(known.array, name=item.sensor)
    return Pad(array, absent, known, None, known.electronics.full_scale)
