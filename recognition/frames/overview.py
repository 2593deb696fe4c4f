"""A recording at a glance: each pad's touches, however many frames it has.

A touch is a run of frames in contact; gaps of up to `GAP` frames do not end it, as a light contact flickers.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import cos, degrees, radians, sin
from statistics import median
from typing import Any

import numpy as np

GAP = 2  # frames
SHOWN = 24  # touches in the table

Rows = Sequence[Mapping[str, Any]]


@dataclass(frozen=True)
class FeltTouch:
    """Frames of one pad from making to breaking contact."""

    pad: int
    rows: Rows
    peak: float  # [plateau] of its firmest frame

    @property
    def kinds(self) -> list[tuple[str, float]]:
        """Kinds with their share of the frames, the most frequent first."""
        counts = Counter(str(row["kind"]) for row in self.rows if row["kind"] != "nothing")
        return [(kind, count / counts.total()) for kind, count in counts.most_common()]

    @property
    def lines(self) -> int:
        """Frames with lines."""
        return sum(1 for row in self.rows if row["lines"])

    @property
    def arcs(self) -> int:
        """Frames with arcs."""
        return sum(1 for row in self.rows if row["arcs"])

    @property
    def typical_line(self) -> tuple[float, float] | None:
        """Angle [deg], averaged on the circle of directions, and median offset [mm] of the first lines."""
        first = [row["lines"][0] for row in self.rows if row["lines"]]
        if not first:
            return None
        twice = [radians(2 * line["angle_deg"]) for line in first]
        angle = float(np.arctan2(sum(map(sin, twice)), sum(map(cos, twice)))) / 2 % np.pi
        along = [
            line["offset_mm"] * (1 if cos(radians(line["angle_deg"]) - angle) >= 0 else -1) for line in first
        ]
        return degrees(angle), median(along)

    @property
    def curvatures(self) -> tuple[float, float] | None:
        """Medians of the curved frames' principal curvatures [1/mm]."""
        curved = [
            row["curvatures_per_mm"]
            for row in self.rows
            if row["curvatures_per_mm"] not in (None, [0.0, 0.0])
        ]
        return (median(c[0] for c in curved), median(c[1] for c in curved)) if curved else None

    @property
    def force(self) -> float | None:
        """[N] at its firmest."""
        forces = [row["force_n"] for row in self.rows if row["force_n"] is not None]
        return max(forces) if forces else None


def touches_of(rows: Rows, peaks: Sequence[float], pad: int) -> list[FeltTouch]:
    """The touches of one pad, in order."""
    mine = [(row, peak) for row, peak in zip(rows, peaks, strict=True) if row["pad"] == pad]
    touches: list[FeltTouch] = []
    first, last = -1, -1
    for i in range(len(mine) + 1):
        if first >= 0 and (i == len(mine) or i - last > GAP + 1):
            part = mine[first : last + 1]
            touches.append(FeltTouch(pad, [row for row, _ in part], max(peak for _, peak in part)))
            first = -1
        if i < len(mine) and mine[i][0]["kind"] != "nothing":
            first, last = (i if first < 0 else first), i
    return touches


def timeline(rows: Rows, peaks: Sequence[float], pad: int, width: int) -> list[tuple[str, float]]:
    """At most `width` (kind, peak) of equal stretches of a pad's frames: the commonest kind, the firmest press."""
    mine = [(str(row["kind"]), peak) for row, peak in zip(rows, peaks, strict=True) if row["pad"] == pad]
    cuts = np.linspace(0, len(mine), min(width, len(mine)) + 1).astype(int)
    out = []
    for a, b in pairwise(cuts.tolist()):
        kinds = Counter(kind for kind, _ in mine[a:b] if kind != "nothing")
        out.append((kinds.most_common(1)[0][0] if kinds else "nothing", max(peak for _, peak in mine[a:b])))
    return out
