"""The settings of `palpate track`: those of exploring, what is tracked, how fast, and the plant."""

from __future__ import annotations

import math
from dataclasses import dataclass

from primitives.errors import PalpateError
from recognition.config import ExploreOptions

WHATS = ("edge", "surface")


@dataclass(frozen=True)
class TrackOptions(ExploreOptions):
    """Everything `palpate track` can be told."""

    sensors: tuple[str, ...] = ("lts210",)
    what: str = "edge"
    speed_mm_s: float = 20.0  # along the edge, or over the surface
    latency_s: float = 0.02  # of the simulated stage; measured, never told to the tracker

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.what not in WHATS:
            raise PalpateError(f"palpate track follows an edge or a surface, not {self.what!r}")
        if not (math.isfinite(self.speed_mm_s) and 1.0 <= self.speed_mm_s <= 200.0):
            raise PalpateError(f"--speed-mm-s must lie between 1 and 200, not {self.speed_mm_s}")
        if not (math.isfinite(self.latency_s) and 0.0 <= self.latency_s <= 0.2):
            raise PalpateError(f"--latency-s must lie between 0 and 0.2, not {self.latency_s}")
