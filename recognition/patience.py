"""When to stop an exploration that learns nothing more.

Progress is a face more, an edge traced, or fewer things open than ever since the last of those.  An object that is
not convex contradicts what the planner believes, which then touches the same places in turn without end.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PatienceConfig:
    """How long to go on without progress."""

    touches: int = 60


class Patience:
    """Counts touches since the last progress."""

    def __init__(self, config: PatienceConfig | None = None) -> None:
        self._config = config or PatienceConfig()
        self._most = 0  # faces and traces
        self._least_open = 0  # since then; 0 until anything was counted
        self._since = 0  # touches at the last progress

    def lost(self, touches: int, known: int, still_open: int) -> bool:
        """Whether too many touches have passed; `known` counts faces and traces."""
        fewer = still_open > 0 and (self._least_open == 0 or still_open < self._least_open)
        if known > self._most:
            self._most, self._least_open, self._since = known, still_open, touches
        elif fewer:
            self._least_open, self._since = still_open, touches
        return touches - self._since > self._config.touches
