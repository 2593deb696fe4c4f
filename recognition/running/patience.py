"""When to take an object for convex no longer, because exploration learns nothing more that way.

Progress is a face more, an edge traced, or a good share fewer things open than at the last progress.  An object
that is not convex contradicts what the planner believes, which then touches the same places in turn, giving up
one by one.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PatienceConfig:
    """How long to go on without progress."""

    touches: int = 40
    share: float = 0.8  # of the open things, to which they must come down to count as progress


class Patience:
    """Counts touches since the last progress."""

    def __init__(self, config: PatienceConfig | None = None) -> None:
        self._config = config or PatienceConfig()
        self._most = 0  # faces and traces
        self._open = 0  # things open at the last progress; 0 until anything was counted
        self._since = 0  # touches at the last progress

    def lost(self, touches: int, known: int, still_open: int) -> bool:
        """Whether too many touches have passed; `known` counts faces and traces."""
        first_count = self._open == 0 and still_open > 0
        if known > self._most or first_count or still_open < self._config.share * self._open:
            self._most, self._open, self._since = max(known, self._most), still_open, touches
        return touches - self._since > self._config.touches
