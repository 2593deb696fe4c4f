"""What a run sees, written down: every frame and event to the recording, and a choice of frames for the report.

The choice is bounded while the run lasts: when a list is full every second frame of it goes and half as many are
taken from then on.  Frames in contact have their own, longer list, because those are what one wants to look at.
The wrench is that of the pressure on the taxels about the pad's center: with f the force on a taxel at (x, y),
force (0, 0, -sum f) and torque (-sum y f, sum x f, 0), in the sensor's frame.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from exploration.devices.guard import Guard, Observation
from exploration.recordings.mcap import Recorder
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.hough import sure_lines
from exploration.sensing.load import Load, load_of
from exploration.sensing.spec import SensorSpec
from primitives.arrays import Floats
from primitives.evidence import EdgeTrace
from recognition.console.interrupts import checkpoint
from recognition.report.one_grid import laid
from recognition.report.run_report import EMPTY_FRAMES, ReportFrames

APPROACH, STROKE = "approach", "stroke"  # the events with which a touch and a stroke begin


@dataclass(frozen=True)
class LogConfig:
    """How much is kept for the report."""

    contact_frames: int = 120
    free_frames: int = 45
    sigmas: float = 6.0  # a frame is in contact when its force is this far out of its noise


@dataclass(frozen=True)
class _Kept:
    seen: Observation
    touch: int  # -1 where nothing is touched

    @cached_property
    def lines(self) -> Floats:
        """(k, 2) angle [rad] and offset [mm] of each line in it, found once however often it is shown."""
        found = () if self.touch < 0 else sure_lines(self.seen.image)
        return np.array([(line.angle, line.offset) for line in found]).reshape(-1, 2)


class Logbook:
    """Watches a guard."""

    def __init__(
        self, recorder: Recorder, config: LogConfig | None = None, specs: Sequence[SensorSpec] = ()
    ) -> None:
        self._recorder, self._specs = recorder, tuple(specs)
        self._config = config or LogConfig()
        self._contact = Thinned(self._config.contact_frames)
        self._free = Thinned(self._config.free_frames)
        self._time, self._begun = 0.0, {APPROACH: 0, STROKE: 0}
        self._drawn: set[str] = set()  # arrays whose size is recorded

    def observe(self, guard: Guard, seen: Observation) -> None:
        """Write one observation down; whoever wants to end the run does so after it."""
        self._time = seen.time
        for kind, count in ((APPROACH, guard.cost.touches), (STROKE, guard.cost.strokes)):
            if count > self._begun[kind]:
                self._begun[kind] = count
                self.announce(kind, {"number": count})
        array = seen.image.array
        if array.name not in self._drawn:
            self._recorder.pad(array.name, array.size, seen.time)
            self._drawn.add(array.name)
        self._recorder.frame(array.name, seen.frame, seen.world_from_sensor, wrench(seen.load))
        if seen.force > self._config.sigmas * seen.load.sigma:
            self._contact.offer(_Kept(seen, guard.cost.touches - 1))
        else:
            self._free.offer(_Kept(seen, -1))
        checkpoint()

    def announce(self, kind: str, detail: Mapping[str, object]) -> None:
        """Write down that something happened, now."""
        self._recorder.event(self._time, kind, detail)

    def announce_trace(self, trace: EdgeTrace) -> None:
        """Write down where a tracked edge ran."""
        self.announce("trace", {"points_mm": np.round(trace.points, 5).tolist(), "closed": trace.closed})

    def frames(self) -> ReportFrames:
        """The frames that were kept, in order, and the lines in those that touched."""
        kept = sorted([*self._contact.kept, *self._free.kept], key=lambda item: item.seen.time)
        if not kept:
            return EMPTY_FRAMES
        return ReportFrames(
            times=np.array([item.seen.time for item in kept]),
            poses=np.stack([item.seen.world_from_sensor for item in kept]),
            counts=np.stack([self._shown(item.seen) for item in kept]),
            forces=np.array([item.seen.force for item in kept]),
            touch=np.array([item.touch for item in kept]),
            lines=[item.lines for item in kept],
        )

    def _shown(self, seen: Observation) -> Floats:
        """The counts of a frame on the grid of the first array."""
        if seen.sensor == 0:
            return seen.frame.counts
        return laid(seen.frame.counts, self._specs[seen.sensor], self._specs[0])


class Thinned:
    """At most `most` of what it is offered, evenly spread, without knowing how much will come."""

    def __init__(self, most: int) -> None:
        self.kept: list[_Kept] = []
        self._most, self._stride, self._count = most, 1, 0

    def offer(self, item: _Kept) -> None:
        """Keep it if its turn has come."""
        if self._count % self._stride == 0:
            if len(self.kept) == self._most:
                self.kept = self.kept[::2]
                self._stride *= 2
            if self._count % self._stride == 0:
                self.kept.append(item)
        self._count += 1


def wrench(load: Load) -> Floats:
    """(6,) force [N] and torque about the pad's center [N mm], in the sensor's frame."""
    return np.array([0.0, 0.0, -load.force, load.about_x, load.about_y, 0.0])


def force_sigma(image: TactileImage) -> float:
    """[N] standard deviation of the sum over the taxels."""
    return load_of(image).sigma
