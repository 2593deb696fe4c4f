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

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 < self.confidence < 1.0:
            raise PalpateError(f"--confidence must lie between 0 and 1, not {self.confidence}")
        if not 0.0 <= self.unknown < 1.0:
            raise PalpateError(f"--unknown must be a probability below 1, not {self.unknown}")
