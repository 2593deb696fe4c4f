"""The settings of `palpate identify`: those of exploring, the library, the policy, and when to stop."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from primitives.errors import PalpateError
from recognition.config import ExploreOptions

POLICIES = ("information", "random", "grid", "largest-gap", "planar")


@dataclass(frozen=True)
class IdentifyOptions(ExploreOptions):
    """Everything `palpate identify` can be told."""

    policies: ClassVar[tuple[str, ...]] = POLICIES
    sensors: tuple[str, ...] = ("lts210",)
    max_touches: int = 40
    library: Path | None = None  # a folder of CAD files; None: the built-in parts
    policy: str = "information"
    confidence: float = 0.95
    unknown: float = 0.1  # prior probability that it is none of the library's objects
    pose_mm: float = 0.15  # [mm] error of the place, 1 sigma, and
    pose_deg: float = 0.25  # [deg] of the attitude, down to which a named object is touched
    pose_touches: int = 3  # that are made for the pose alone, at most

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 < self.confidence < 1.0:
            raise PalpateError(f"--confidence must lie between 0 and 1, not {self.confidence}")
        if not 0.0 <= self.unknown < 1.0:
            raise PalpateError(f"--unknown must be a probability below 1, not {self.unknown}")
        for flag, value in (("--pose-mm", self.pose_mm), ("--pose-deg", self.pose_deg)):
            if not 0.0 < value < float("inf"):
                raise PalpateError(f"{flag} must be above 0, not {value}")
        if self.pose_touches < 0:
            raise PalpateError(f"--pose-touches must be 0 or more, not {self.pose_touches}")
