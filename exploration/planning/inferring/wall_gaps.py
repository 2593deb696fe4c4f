"""Gaps in the wall of a cylinder, with straight sides along its axis, in the pictures of pads that lay along it.

The wall is missing in one piece, between rows and columns that show it, and the piece is as wide over most of its
length.  Where its sides are tells the share that an edge has there (`Mosaic.unrolled`), and where it ends the
middle of it (our derivation).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import label

from exploration.planning.known.mosaic import Unrolled
from primitives.arrays import Bools, Floats


@dataclass(frozen=True)
class WallGapsConfig:
    """What is a gap."""

    level: float = 0.5  # of the wall's own share, below which it is not there
    wall: float = 0.8  # quantile of all that is known, which is the wall's own share,
    least: float = 0.4  # that this is at least, of a wall that was pressed at all
    standing: float = 0.5  # share of a row that shows the wall, where the cylinder is there at all
    wide: tuple[float, float] = (2.5, 1.2)  # [mm] at least, and of the cylinder's radius at most
    alike: float = 0.8  # [mm] that the width of a row may differ from the median one
    straight: float = 1.0  # widths, over which it is that wide at least
    rough: float = 0.35  # [mm] by which its sides may stray from lines along the axis
    open_end: float = 1.5  # [mm] from the end of the cylinder, where it goes on through that


@dataclass(frozen=True)
class WallGap:
    """Where the wall is missing, all in one piece."""

    turn: float  # [rad] of its middle, in the cylinder's frame
    width: float  # [mm] straight across
    low: float  # [mm] heights along the cylinder
    high: float
    open_low: bool  # whether it goes on through the cylinder's ends
    open_high: bool


def wall_gaps(seen: Unrolled, radius: float, config: WallGapsConfig = WallGapsConfig()) -> Iterator[WallGap]:
    """Those of a convex cylinder of a radius [mm], but none that goes on through both of its ends."""
    if not seen.known.any():
        return
    own = float(np.quantile(seen.share[seen.known], config.wall))
    if own < config.least:
        return
    level = config.level * own
    there = seen.known & (seen.share >= level)
    standing = np.flatnonzero(there.sum(axis=1) > config.standing * seen.known.sum(axis=1).clip(1))
    if len(standing) < 2:
        return
    seam = int(there.sum(axis=0).argmax())  # no gap lies across the column that shows most of the wall
    wall = seen.part(slice(standing[0], standing[-1] + 1), seam)
    pieces, count = label(wall.known & (wall.share < level))
    for number in range(1, count + 1):
        gap = _straight(pieces == number, wall, level, radius, config)
        if gap is not None:
            yield replace(gap, turn=gap.turn + float(seen.turns[seam]))


def _straight(
    piece: Bools, wall: Unrolled, level: float, radius: float, config: WallGapsConfig
) -> WallGap | None:
    """A piece of what is missing, if its sides are straight; its turn is from the first column."""
    at, turns = _sides(piece, wall, level)
    if not len(at):
        return None
    widths = 2.0 * radius * np.sin(np.minimum(0.5 * (turns[:, 1] - turns[:, 0]), 0.5 * np.pi))
    like = np.abs(widths - np.median(widths)) < config.alike
    if not like.any():
        return None
    width, middle = float(np.median(widths[like])), float(turns[like].mean())
    length = float(like.sum()) * float(wall.heights[1] - wall.heights[0])
    stray = float(radius * turns[like].std(axis=0).max())
    if not config.wide[0] < width < config.wide[1] * radius:
        return None
    if length < config.straight * width or stray > config.rough:
        return None
    column = int(np.abs(wall.turns - middle).argmin())
    inside = np.flatnonzero(piece[:, column])
    if not len(inside):
        return None
    past, ends = [], []
    for row, way, last in ((int(inside[0]), -1, 0), (int(inside[-1]), 1, len(wall.heights) - 1)):
        past.append(abs(float(wall.heights[row] - wall.heights[last])) < config.open_end)
        if not past[-1] and not wall.known[row + way, column]:
            return None  # nobody looked where it ends
        ends.append(float(wall.heights[row]) if past[-1] else _end(wall, column, row, way, level))
    return None if all(past) else WallGap(middle, width, ends[0], ends[1], past[0], past[1])


def _sides(piece: Bools, wall: Unrolled, level: float) -> tuple[Floats, Floats]:
    """(n,) heights [mm] of rows with wall on both sides of a piece, and (n, 2) turns [rad] of its sides there."""
    heights, sides = [], []
    for row in np.flatnonzero(piece.any(axis=1)):
        columns = np.flatnonzero(piece[row])
        before, after = int(columns[0]) - 1, int(columns[-1]) + 1
        if before >= 0 and after < piece.shape[1] and wall.known[row, [before, after]].all():
            over = slice(before, after + 1)
            share, edge = wall.share[row, over], 2.0 * wall.edge[row, over]
            heights.append(wall.heights[row])
            left, right = share - (1.0 - edge) * level, share - (1.0 + edge) * level
            sides.append((before + _past(left), after - _past(right[::-1])))
    return np.array(heights), np.array(sides).reshape(-1, 2) * float(wall.turns[1])


def _past(over: Floats) -> float:
    """Of (n,) shares over what an edge has, from the wall into a gap: how many places on it falls under that."""
    inside = int((over < 0.0).argmax())
    if inside == 0:
        return 0.0 if over[0] < 0.0 else float(len(over) - 1)
    return float(inside - over[inside] / (over[inside] - over[inside - 1]))


def _end(wall: Unrolled, column: int, row: int, way: int, level: float) -> float:
    """[mm] the height at which a column passes the level, between the last row of a gap and the next."""
    inside, beyond = (float(wall.share[k, column]) for k in (row, row + way))
    past = float(np.clip((level - inside) / max(beyond - inside, 1e-9), 0.0, 1.0))
    return float(wall.heights[row] + past * (wall.heights[row + way] - wall.heights[row]))
