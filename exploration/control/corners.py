"""Corners of an outline: two straight edges that meet in one place, however the pad moves.

A frame at a rounded bend may be explained by two lines as well, but where they meet wanders along the bend while
the pad goes by.  A corner is where the same meeting is seen from several places.  Once noise is averaged, a bend
shows a third line between the two: an edge that turns again beside the corner is not taken for one with a corner.
"""

from dataclasses import dataclass
from math import dist

import numpy as np

from exploration.devices.guard import Observation
from exploration.sensing.lines.followed import Followed
from exploration.sensing.lines.line import Line
from exploration.sensing.lines.outline import find_outline
from primitives.arrays import Floats

FORWARD = 0.3  # least cosine between a line that is come along and the edge that was followed


@dataclass(frozen=True)
class CornerConfig:
    """When two lines are a corner."""

    turns: float = 0.2  # |sine| of the angle between two edges, from which they are two
    length: float = 4.0  # [mm] of a line that is an edge
    sure: float = 3.0  # [standard deviations of chi2] within which the lines must explain the frame
    looks: int = 3  # that must agree
    apart: float = 0.45  # [mm] by which meetings may differ
    turned: float = 0.06  # [rad] by which their angles may
    reach: float = 1.0  # [mm] from a corner, within which its edges end, and are seen to meet once more
    turning: float = 0.15  # [rad] by which they may turn otherwise then
    far: float = 8.0  # [mm] from a corner, beyond which a line that ends there is no edge of it
    aside: float = 0.5  # [rad] from the followed edge, beyond which another is preferred


@dataclass(frozen=True)
class Meeting:
    """Two edges that meet: the way the material's hand is kept, from one to the other."""

    point: Floats  # (3,) [mm] in the world
    inward: Floats  # (3,) unit direction into the material from the edge ahead
    along: Floats  # (3,) unit direction of travel on the edge ahead
    angle: float  # [rad] between the two
    ahead: float  # [mm] from the pad's center, along the edge behind
    aside: float  # [rad] by which the edge behind runs otherwise than the one that was followed


def meeting(
    seen: Observation, edge: Followed, config: CornerConfig, lines: tuple[Line, ...] = ()
) -> Meeting | None:
    """The meeting of the two edges under the pad; None where the frame shows no two, or is not explained by them.

    `lines` are taken as they are instead of being looked for.
    """
    if not lines:
        outline = find_outline(seen.image, 3)
        if outline.arcs or not outline.explains(config.sure):
            return None
        lines = outline.lines
    pairs = [
        pair
        for pair in _pairs(lines, edge, config)
        if pair.come @ edge.direction > FORWARD and pair.short < config.far
    ]
    found = [_in_world(seen, pair, edge) for pair in pairs]
    return min(found, key=lambda met: (met.aside > config.aside, abs(met.ahead)), default=None)


def too_short(seen: Observation, edge: Followed, clear: float, config: CornerConfig) -> bool:
    """Whether an edge's two ends are so near that all of it lies within `clear` [mm] of a corner."""
    return edge.ahead + edge.behind < 2.0 * clear and meeting(seen, edge, config) is not None


def ends_at_corner(
    seen: Observation, edge: Followed, last: Followed, clear: float, config: CornerConfig
) -> bool:
    """Whether an edge was lost because another meets it where its face ends, within `clear` [mm] ahead."""
    return min(edge.ahead, edge.opens) < clear and meeting(seen, last, config) is not None


def agreed(meetings: list[Meeting], config: CornerConfig) -> bool:
    """Whether the last meetings are one corner."""
    last = meetings[-config.looks :]
    if len(last) < config.looks:
        return False
    points = np.array([m.point for m in last])
    angles = np.array([m.angle for m in last])
    spread = float(np.linalg.norm(points - points.mean(axis=0), axis=1).max())
    return spread < config.apart and float(np.ptp(angles)) < config.turned


def is_sharp(seen: Observation, edge: Followed, corner: Meeting, config: CornerConfig) -> bool:
    """Whether a quiet frame shows the same corner, its edges running up to it and turning nowhere else."""
    outline = find_outline(seen.image, 3)
    if outline.arcs or not outline.explains(config.sure):
        return False
    pairs = [pair for pair in _pairs(outline.lines, edge, config) if pair.short < config.reach]
    for pair in pairs:
        met = _in_world(seen, pair, edge)
        if dist(met.point, corner.point) < config.reach and abs(met.angle - corner.angle) < config.turning:
            return not any(p.behind is pair.ahead or p.ahead is pair.behind for p in pairs)
    return False


@dataclass(frozen=True)
class _Pair:
    """Two lines of a frame that meet, directed the way that the material's hand is kept."""

    behind: Line
    ahead: Line
    corner: Floats  # (2,) [mm]
    come: Floats  # (2,) unit direction of travel on the line behind
    go: Floats  # (2,) on the one ahead

    @property
    def short(self) -> float:
        """[mm] from the corner to where the line that ends farther from it ends."""
        ends = [(line.start, line.end) for line in (self.behind, self.ahead)]
        return max(min(dist(start, self.corner), dist(end, self.corner)) for start, end in ends)


def _pairs(lines: tuple[Line, ...], edge: Followed, config: CornerConfig) -> list[_Pair]:
    """All of which one is come along and the other gone on."""
    found: list[_Pair] = []
    long = [line for line in lines if line.length > config.length]
    for behind in long:
        for ahead in long:
            sine = float(behind.direction @ ahead.inward)
            if abs(sine) < config.turns:
                continue
            foot = ahead.offset * ahead.normal
            share = float((behind.offset * behind.normal - foot) @ behind.inward)
            corner = foot + share / float(ahead.direction @ behind.inward) * ahead.direction
            come = edge.side * np.array([behind.inward[1], -behind.inward[0]])
            go = edge.side * np.array([ahead.inward[1], -ahead.inward[0]])
            came = float((0.5 * (behind.start + behind.end) - corner) @ come) < 0.0
            goes = float((0.5 * (ahead.start + ahead.end) - corner) @ go) > 0.0
            if came and goes:
                found.append(_Pair(behind, ahead, corner, come, go))
    return found


def _in_world(seen: Observation, pair: _Pair, edge: Followed) -> Meeting:
    turn, at = seen.world_from_sensor[:3, :2], seen.world_from_sensor[:3, 3]
    angle = float(np.arccos(np.clip(pair.go @ pair.come, -1.0, 1.0)))
    aside = float(np.arccos(np.clip(pair.come @ edge.direction, -1.0, 1.0)))
    ahead = float(pair.corner @ pair.come)
    return Meeting(turn @ pair.corner + at, turn @ pair.ahead.inward, turn @ pair.go, angle, ahead, aside)
