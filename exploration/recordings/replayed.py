"""A recording as devices: an array that reads its frames, on a stage that goes where it went.

    stage, array = replayed(open_recording(path))
    guard = Guard(stage, [array], [Calibration.nominal(spec)])
    guard.observe()                # the first frame as it was recorded, at the pose that it was recorded at

What was not recorded cannot be felt, so a wish to move is heard and changes nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import numpy as np

from exploration.devices.protocols import MotionStage, StageLimits
from exploration.recordings.recording import PadFrame, Recording
from exploration.sensing.frame import TaxelArray, TaxelFrame
from primitives import pose as se3
from primitives.arrays import Floats, frozen
from primitives.errors import PalpateError

_LOOKED_AT = 50  # frames from which the period is told
_PERIOD = 0.01  # [s] where the recording has no times


class ReplayedStage(MotionStage):
    """A `MotionStage` that stands where it stood when the frame read last was made."""

    limits = StageLimits()
    moving = False

    def __init__(self, world_from_flange: Floats) -> None:
        self._at = world_from_flange

    def pose(self) -> Floats:
        """(4, 4) world_from_flange."""
        return self._at

    def move(self, twist: Floats) -> None:
        """It goes where it went."""

    def go_to(self, world_from_flange: Floats) -> None:
        """It goes where it went, and has arrived."""

    def stop(self) -> None:
        """It stands already."""

    def was_at(self, world_from_flange: Floats) -> None:
        """Where it was when the next frame was made."""
        self._at = world_from_flange


class ReplayedArray:
    """A `TactileSensor` that reads one pad's frames, one after the other."""

    def __init__(self, recording: Recording, pad: int, stage: ReplayedStage, mount: Floats) -> None:
        self.period = _period(_of(recording, pad))
        self.array: TaxelArray = recording.pads[pad].array
        self.flange_from_sensor = frozen(mount)
        self._path, self._stage = recording.path, stage
        self._sensor_from_flange = se3.inverse(mount)
        self._frames, self._time = _of(recording, pad), 0.0

    def read(self) -> TaxelFrame:
        """The next frame; a recording without times gets those of its period."""
        item = next(self._frames, None)
        if item is None:
            raise PalpateError(f"{self._path} has ended; there is nothing more to feel in it")
        if item.world_from_sensor is not None:
            self._stage.was_at(item.world_from_sensor @ self._sensor_from_flange)
        self._time = item.frame.time if np.isfinite(item.frame.time) else self._time + self.period
        return TaxelFrame(item.frame.counts, self._time, item.frame.index)


def replayed(
    recording: Recording, pad: int = 0, flange_from_sensor: Floats | None = None
) -> tuple[ReplayedStage, ReplayedArray]:
    """Stage and array of one pad of a recording; one without poses stands at the world's origin."""
    mount = np.eye(4) if flange_from_sensor is None else flange_from_sensor
    stage = ReplayedStage(se3.inverse(mount))
    return stage, ReplayedArray(recording, pad, stage, mount)


def _of(recording: Recording, pad: int) -> Iterator[PadFrame]:
    if not 0 <= pad < len(recording.pads):
        told = f"pads 0 to {len(recording.pads) - 1}"
        raise PalpateError(f"{recording.path} has {told}, and no pad {pad}; name one of them")
    return (item for item in recording.frames() if item.pad == pad)


def _period(frames: Iterator[PadFrame]) -> float:
    steps = np.diff([item.frame.time for item in islice(frames, _LOOKED_AT)])
    steps = steps[np.isfinite(steps) & (steps > 0.0)]
    return float(np.median(steps)) if len(steps) else _PERIOD
