"""`palpate frames`, conducted: open, calibrate, perceive, draw."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import islice

from exploration.recordings.recording import PadFrame, Recording
from exploration.recordings.untouched import Untouched
from exploration.sensing.calibration import Calibration
from primitives.errors import PalpateError
from recognition.frames.felt import Feeler, Felt, unreadable_warnings
from recognition.frames.options import FramesOptions
from recognition.frames.rows import Row, frame_row, pad_row


@dataclass(frozen=True)
class Seen:
    """A recording, understood."""

    recording: Recording
    feeler: Feeler
    rows: list[Row]  # one per frame and pad
    peaks: list[float] = field(default_factory=list)  # [plateau] of each row, for the overview
    shown: list[Felt] = field(default_factory=list)  # the frames of --index
    pictures: int = 0

    @property
    def summary(self) -> dict[str, object]:
        """What `--json` prints."""
        pads = zip(self.recording.pads, self.feeler.rests, strict=True)
        return {
            "command": "frames",
            "file": str(self.recording.path),
            "sensor": self.recording.sensor,
            "pads": [pad_row(i, pad, rest.noise, rest.plateau) for i, (pad, rest) in enumerate(pads)],
            "poses": self.recording.posed,
            "frames": self.rows,
            "warnings": self.warnings,
        }

    @property
    def warnings(self) -> list[str]:
        """What was assumed, and what could not be read."""
        reasons = [str(row.get("unreadable", "")) for row in self.rows]
        return [*self.recording.warnings, *unreadable_warnings(reasons)]


Tell = Callable[[str, int, int], object]  # phase, frames done, frames in all (0: not known)


def run(
    options: FramesOptions,
    recording: Recording,
    tell: Tell = lambda *_: None,
    calibration: Calibration | None = None,
) -> Seen:
    """Perceive what was asked of a recording; `calibration` is its array's own, where there is one."""
    feeler = Feeler.of(recording, _told(recording.frames(), "reading", 0, tell), calibration)
    total = sum(feeler.frame_counts) if options.index is None else 0
    asked = _asked(options, feeler)
    folder = options.folder()
    seen = Seen(recording, feeler, [])
    pictures = 0
    for felt in feeler.feel(_told(asked, "perceiving", total, tell)):
        row = frame_row(felt, recording.pads[felt.pad])
        rest = feeler.rests[felt.pad]
        seen.rows.append(row)
        seen.peaks.append(_peak(felt, rest) if felt.touch else 0.0)
        if options.index is not None:
            seen.shown.append(felt)
        if folder is not None and felt.touch:
            from recognition.frames.picture import write_picture

            row["png"] = write_picture(folder, felt, recording.pads[felt.pad], rest)
            pictures += 1
    return Seen(recording, feeler, seen.rows, seen.peaks, seen.shown, pictures)


def _asked(options: FramesOptions, feeler: Feeler) -> Iterator[PadFrame]:
    """All frames, or those of one index."""
    frames = feeler.recording.frames()
    if options.index is None:
        return frames
    count = max(feeler.frame_counts)
    if options.index >= count:
        raise PalpateError(f"--index {options.index}: {options.file} has frames 0 to {count - 1}")
    asked = (item for item in frames if item.frame.index == options.index)
    return islice(asked, sum(held > options.index for held in feeler.frame_counts))


def _peak(felt: Felt, rest: Untouched) -> float:
    return float((felt.counts - rest.zero).max()) / rest.plateau if rest.plateau else 1.0


def _told(frames: Iterator[PadFrame], phase: str, total: int, tell: Tell) -> Iterator[PadFrame]:
    for done, item in enumerate(frames):
        if done % 64 == 0:
            tell(phase, done, total)
        yield item
