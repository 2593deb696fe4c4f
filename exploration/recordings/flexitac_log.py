"""`.bin` logs of a FlexiTac: the bytes of its port as they came, `AA 55` and a byte a taxel, again and again.

`cat /dev/ttyUSB0 > log.bin` makes one.  It may begin and end within a frame.  Without a sensor the number of
taxels is that of the built-in array whose frames follow each other most often.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from exploration.devices.wire import flexitac
from exploration.devices.wire.stream import Stream
from exploration.recordings.intake import opened
from exploration.recordings.layout import layout_of, plain_warnings
from exploration.recordings.recording import PadFrame, Recording
from exploration.sensing.frame import TaxelFrame
from exploration.sensing.spec import SensorSpec, load_sensor, sensor_names
from primitives.arrays import Floats, frozen
from primitives.errors import PalpateError

_AT_ONCE = 1 << 16  # [bytes]
_FULL = 255.0  # [counts]


def read_flexitac(path: Path, spec: SensorSpec | None = None) -> Recording:
    """The frames of a log."""
    cells = _cells(path) if spec is None else spec.array.rows * spec.array.columns
    count, skipped = _counted(path, cells)
    if not count:
        raise PalpateError(
            f"{path}: no frame AA 55 of {cells} taxels in it; name its array: --sensor NAME or FILE.toml"
        )
    layout = layout_of(str(path), (count, cells), spec, _FULL)
    pad = layout.pads[0]

    def replay() -> Iterator[PadFrame]:
        for index, counts in enumerate(
            _frames(path, Stream(lambda data, locked: flexitac.cut(data, cells, locked)))
        ):
            yield PadFrame(0, TaxelFrame(frozen(counts.reshape(pad.array.shape)), np.nan, index))

    told = (f"{skipped} bytes belong to no whole frame",) if skipped else ()
    assumed = (*layout.assumed, *told, *plain_warnings(layout.pads, timed=False, posed=False))
    return Recording(path, pad.array.name, layout.pads, replay, False, False, assumed)


def _counted(path: Path, cells: int) -> tuple[int, int]:
    """Frames, and bytes that belong to none."""
    stream = Stream(lambda data, locked: flexitac.cut(data, cells, locked))
    count = sum(1 for _ in _frames(path, stream))
    return count, stream.skipped + stream.waiting


def _frames(path: Path, stream: Stream) -> Iterator[Floats]:
    with opened(path) as file:
        while data := file.read(_AT_ONCE):
            for raw in stream.feed(data):
                yield raw.counts


def _cells(path: Path) -> int:
    """The number of taxels that fits best among the built-in arrays'."""
    with opened(path) as file:
        data = file.read(_AT_ONCE)
    at = {k for k in range(len(data) - 1) if data[k : k + 2] == flexitac.MARKER}
    known = {load_sensor(name).array.rows * load_sensor(name).array.columns for name in sensor_names()}
    follow = Counter({n: sum(k + n + len(flexitac.MARKER) in at for k in at) for n in sorted(known)})
    best, times = follow.most_common(1)[0]
    if not times:
        raise PalpateError(
            f"{path}: no AA 55 follows another at a built-in array's distance; give --sensor FILE.toml"
        )
    return best
