"""Where an outline comes back to itself: to the start of any of its edges, or to a corner that it met.

An outline need not begin on the loop that it runs into: what precedes the loop leads in.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import dist

import numpy as np

from exploration.control.closing import ClosingConfig, Home
from exploration.control.corners import Meeting
from exploration.control.track_edge import Tracked
from primitives.evidence import EdgeTrace


@dataclass(frozen=True)
class Start:
    """Where an edge began, by which a later one may come."""

    edge: Tracked
    trace: EdgeTrace
    number: int  # of edges drawn before
    travel: float  # [mm] until there

    def home(self, gone: float, config: ClosingConfig) -> Home:
        """For the next edge, after `gone` [mm]; the very first counts at once, as a small loop has no more."""
        after = self.travel + config.least_loop - gone if self.number else 0.0
        return Home(self.trace.points[0], self.trace.tangents[0], after)


@dataclass(frozen=True)
class MetCorner:
    """A corner that was met."""

    met: Meeting
    drawn: int  # edges, until there
    travel: float  # [mm] from which a loop back to it is counted


def met_again(corners: Sequence[MetCorner], met: Meeting, travel: float, config: ClosingConfig) -> int | None:
    """How many edges led to the corner that is come to again, after `travel` [mm]; None where it is another."""
    for corner in corners:
        near = dist(corner.met.point, met.point) < config.aside
        same_way = float(corner.met.along @ met.along) > config.same_way
        if near and same_way and travel - corner.travel > config.least_loop:
            return corner.drawn
    return None


def lead_of(traces: Sequence[EdgeTrace], begun: int, config: ClosingConfig) -> int:
    """How many edges precede a loop that comes back to a corner, to which `begun` edges led.

    The last of those is part of the loop where the loop's last edge runs along it.
    """
    if not begun:
        return 0
    led, last = traces[begun - 1], traces[-1]
    middle = len(led.points) // 2
    off = np.linalg.norm(last.points - led.points[middle], axis=1)
    same_way = float(last.tangents[off.argmin()] @ led.tangents[middle]) > config.same_way
    return begun - 1 if same_way and off.min() < 2.0 * config.aside else begun
