"""One trial of a suite: what is done and with which settings; and the row that it becomes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from recognition.experiments.settings import Value

DONE, FAILED, TIMEOUT, MEMORY, LOST = "done", "failed", "timeout", "memory", "lost"
OUTCOMES = (DONE, FAILED, TIMEOUT, MEMORY, LOST)
Row = dict[str, Value]
ROOM = "palpate-suite-"  # what folders begin with that trials are done in


@dataclass(frozen=True)
class Trial:
    """What to do; `number` is its place in the suite, and in the table."""

    number: int
    group: str
    kind: str
    settings: Mapping[str, Value]
    base: str  # folder that relative files of the settings are in

    def as_json(self) -> dict[str, Any]:
        """As workers are told."""
        return {
            "number": self.number,
            "group": self.group,
            "kind": self.kind,
            "settings": dict(self.settings),
            "base": self.base,
        }

    @staticmethod
    def from_json(told: Mapping[str, Any]) -> Trial:
        """The same again."""
        return Trial(told["number"], told["group"], told["kind"], told["settings"], told["base"])

    def row(
        self,
        outcome: str,
        reason: str = "",
        metrics: Mapping[str, Value] | None = None,
        seconds: float | None = None,
    ) -> Row:
        """What came of it, one value a column."""
        head: Row = {"trial": self.number, "group": self.group, "kind": self.kind}
        return {
            **head,
            **self.settings,
            "outcome": outcome,
            "reason": reason,
            **(metrics or {}),
            "trial_seconds": seconds,
        }


@dataclass(frozen=True)
class Work:
    """Where a trial does what it does."""

    base: Path  # relative files of the settings are in here
    scratch: Path  # an empty folder of its own; what is left in it is removed, or kept as the trial's run

    def file(self, named: str) -> str:
        """A setting that names a file, or something built in, as something to open."""
        path = self.base / named
        looks = "." in path.name or "/" in named  # else a folder of the same name would hide what is built in
        return str(path) if looks and path.exists() else named
