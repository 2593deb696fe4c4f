"""Every frame of a recording, perceived.

A frame that no array at rest or in contact can deliver is not perceived but said to be unreadable: values that are
not finite, values far below an untouched taxel's, or all taxels at the end of their range (which shows neither an
edge nor a surface, only that the press is too firm).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from exploration.recordings.recording import Pad, PadFrame, Recording
from exploration.recordings.untouched import ABSURD, STILL, Untouched, at_rest, calibration_at_rest
from exploration.sensing.calibration import Calibration, correct
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.arc import Arc
from exploration.sensing.touch import Touch, perceive
from primitives.arrays import Floats

BELOW = 0.25  # [plateau] below zero from which counts cannot be those of a press


@dataclass(frozen=True)
class Felt:
    """One frame of one pad, understood."""

    pad: int
    index: int
    time: float  # [s]; nan where the recording has none
    counts: Floats  # (rows, columns)
    image: TactileImage
    touch: Touch
    unreadable: str = ""  # why it was not perceived
    world_from_sensor: Floats | None = None  # (4, 4)

    @property
    def arcs(self) -> tuple[Arc, ...]:
        """Circular edges, where perception gives any."""
        return getattr(self.touch, "arcs", ())


@dataclass(frozen=True)
class Feeler:
    """A recording with the calibration that it allows."""

    recording: Recording
    rests: tuple[Untouched, ...]
    calibrations: tuple[Calibration, ...]

    @staticmethod
    def of(
        recording: Recording,
        frames: Iterator[PadFrame] | None = None,
        calibration: Calibration | None = None,
    ) -> "Feeler":
        """Calibrate from one pass over the recording; a broken file is found out here.

        A `calibration` of the array's own, made earlier, leaves its zeros to be told.
        """
        rests = at_rest(recording, frames)
        if calibration is not None:
            return Feeler(recording, rests, tuple(replace(calibration, zero=rest.zero) for rest in rests))
        pairs = zip(recording.pads, rests, strict=True)
        return Feeler(recording, rests, tuple(calibration_at_rest(pad, rest) for pad, rest in pairs))

    @cached_property
    def frame_counts(self) -> tuple[int, ...]:
        """Frames of each pad."""
        return tuple(rest.frames for rest in self.rests)

    def feel(self, frames: Iterator[PadFrame] | None = None) -> Iterator[Felt]:
        """Perceive frame after frame."""
        for item in self.recording.frames() if frames is None else frames:
            yield self.perceived(item)

    def perceived(self, item: PadFrame) -> Felt:
        """One frame."""
        pad, rest, calibration = (
            self.recording.pads[item.pad],
            self.rests[item.pad],
            self.calibrations[item.pad],
        )
        wrong = unreadable(item.frame.counts, pad, rest)
        readable = replace(item.frame, counts=calibration.zero) if wrong else item.frame
        image = correct(readable, calibration, pad.array)
        return Felt(
            item.pad,
            item.frame.index,
            item.frame.time,
            item.frame.counts,
            image,
            perceive(image),
            wrong,
            item.world_from_sensor,
        )


def unreadable(counts: Floats, pad: Pad, rest: Untouched) -> str:
    """Why a frame shows nothing that could be perceived; empty where it may."""
    living = counts[~pad.absent]
    if not (np.abs(living) < ABSURD).all():
        return "not finite"
    if not living.size or living.min() < -max(STILL * rest.noise, BELOW * rest.plateau):
        return "below zero"
    level = living.size > 1 and living.min() == living.max()
    if living.min() >= pad.full_scale or (
        level and (living > rest.zero[~pad.absent] + STILL * rest.noise).all()
    ):
        return "saturated"
    return ""


def unreadable_warnings(reasons: Sequence[str]) -> list[str]:
    """How many frames could not be read, by reason."""
    fixes = {
        "not finite": "hold values that are missing or not finite",
        "below zero": "hold counts far below zero; touched taxels must read higher",
        "saturated": "are saturated all over; press less",
    }
    return [
        f"{reasons.count(reason)} of {len(reasons)} frames {fix}: nothing is read in them"
        for reason, fix in fixes.items()
        if reason in reasons
    ]
