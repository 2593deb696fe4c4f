"""What a run tells whoever watches it; the watcher draws, the run never does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from recognition.report.run_report import RunReport

Page = Callable[[], RunReport]


@dataclass(frozen=True)
class Progress:
    """Where a run stands; counts are since it began."""

    phase: str  # "exploring", "reconstructing", "writing"
    touches: int = 0
    strokes: int = 0
    frames: int = 0
    travel: float = 0.0  # [mm]
    device_time: float = 0.0  # [s]
    open: int = 0  # frontier items that exploration still has to close
    note: str = ""  # the last move, in a few words
    folder: Path | None = None  # where the run is being written
    page: Page | None = (
        None  # makes what a page would show by now; for whoever asks, from the run's own thread
    )

    def within(self, folder: Path) -> Progress:
        """The same, of a run that is written to `folder`."""
        return replace(self, folder=folder)
