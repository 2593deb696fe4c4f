"""A recording that can be gone through again and again: which arrays, and their frames in order of time.

One type for every outside format, so that nothing above can tell a log of somebody else's from an episode of our
own.  `replay` opens the file anew each time and yields as it reads, so a recording of any length needs the memory
of a few frames.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import inf
from pathlib import Path

from exploration.sensing.frame import TaxelArray, TaxelFrame
from exploration.sensing.spec import SensorSpec
from primitives.arrays import Bools, Floats


@dataclass(frozen=True)
class Pad:
    """One array of a recording, and what is known of it."""

    array: TaxelArray
    absent: Bools  # (rows, columns) places without a taxel
    spec: SensorSpec | None = None  # rubber and gains; None where only the layout is known
    zero: float | None = None  # [counts] of an untouched taxel, where the format fixes it
    full_scale: float = inf  # [counts] where the converter ends
    foreign: bool = False  # whether `spec` only stands in for the real rubber and gains
    assumed_pitch: bool = False  # the array's pitch is 1 taxel, for want of a better one


@dataclass(frozen=True)
class PadFrame:
    """One frame of one pad."""

    pad: int
    frame: TaxelFrame  # indices count each pad's frames from 0; the time is nan where the recording has none
    world_from_sensor: Floats | None = None  # (4, 4)


@dataclass(frozen=True)
class JointTrace:
    """How the hand that carried the pads stood."""

    time: Floats  # (n,) [s] on the clock of the frames
    angles: Floats  # (n, joints) [rad]


@dataclass(frozen=True)
class Recording:
    """Frames of one or more pads."""

    path: Path
    sensor: str  # name of the array, or of the arrays
    pads: tuple[Pad, ...]
    replay: Callable[[], Iterator[PadFrame]]
    timed: bool  # whether frames carry a time
    posed: bool  # whether frames carry a pose
    warnings: tuple[str, ...] = ()  # what was assumed
    joints: Callable[[], JointTrace] | None = None  # where the recording has them

    def frames(self) -> Iterator[PadFrame]:
        """Every frame, from the first; raises `PalpateError` where the file turns out broken."""
        return self.replay()
