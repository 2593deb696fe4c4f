"""An array on a port, without a stage: its frames as a recording, as long as one listens.

The array must touch nothing at first, so that its zeros can be told.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np

from exploration.devices.serial_array import SerialArray
from exploration.recordings.recording import Pad, PadFrame, Recording
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import SensorSpec
from primitives.arrays import frozen
from primitives.errors import PalpateError
from recognition.console import interrupts
from recognition.frames.felt import Feeler, Felt
from recognition.hardware.config import load_device
from recognition.hardware.rig import calibration_of, open_array, sensor_of

REST = 30  # frames before anything is touched
_SHOWN = 0.1  # [s] between two frames that are shown
_LONGEST = 100_000  # frames that are kept

Show = Callable[[Felt, Feeler], object]


def listen(path: Path, seconds: float, show: Show) -> tuple[Recording, Calibration | None]:
    """The frames of some seconds (0: until Ctrl-C), the newest shown as they come; and the array's calibration."""
    config = load_device(path)
    spec = sensor_of(config)
    calibration = calibration_of(config, spec)[0] if config.array.calibration else None
    with interrupts.held(), closing(open_array(config)) as array:
        kept: list[PadFrame] = []
        feeler, shown = None, 0.0
        for item in _frames(array, seconds):
            kept.append(item)
            if len(kept) == REST:
                feeler = Feeler.of(_recording(path, spec, kept), calibration=calibration)
            if feeler is not None and item.frame.time - shown > _SHOWN:
                shown = item.frame.time
                show(feeler.perceived(item), feeler)
    if len(kept) < REST:
        raise PalpateError(f"{len(kept)} frames are too few to tell the array's zeros; listen longer")
    return _recording(path, spec, kept), calibration


def _frames(array: SerialArray, seconds: float) -> Iterator[PadFrame]:
    """Frames counted from 0, their times from the first on, until an interrupt."""
    first = array.read()
    frame = first
    for index in range(_LONGEST):
        time = frame.time - first.time
        yield PadFrame(0, replace(frame, index=index, time=time))
        if interrupts.asked() or (seconds and index > REST and time >= seconds):
            return
        frame = array.read()


def _recording(path: Path, spec: SensorSpec, kept: list[PadFrame]) -> Recording:
    everywhere = frozen(np.zeros(spec.array.shape), np.bool_)
    pad = Pad(spec.array, everywhere, spec, full_scale=spec.electronics.full_scale)
    frames = tuple(kept)
    return Recording(path, spec.name, (pad,), lambda: iter(frames), True, False)
