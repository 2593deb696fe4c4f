"""Outline tracking: edge after edge round a face, turning at its corners, until it closes.

At a corner the next edge is the line under the pad that is not the last one, taken the way that keeps the material
on the same hand: a convex corner turns toward the material and an inside one away from it, by the same rule.
"""

from dataclasses import dataclass, field
from itertools import pairwise
from math import dist
from typing import Literal

import numpy as np

from exploration.control.coming_back import MetCorner, Start, lead_of, met_again
from exploration.control.corners import Meeting, meeting
from exploration.control.dwell import dwell
from exploration.control.edge_profile import EdgeProfile
from exploration.control.hybrid import PRESS
from exploration.control.run_on import leading_from, leading_to
from exploration.control.track_edge import EdgeConfig, Tracked, follow_edge
from exploration.control.windows import window_about
from exploration.devices.guard import Collision, Fault, Guard, Observation, OverPress
from exploration.sensing.lines.followed import Followed
from exploration.sensing.lines.hough import sure_lines
from primitives import pose as se3
from primitives.arrays import Floats, frozen
from primitives.evidence import EdgeTrace

DEFAULT = EdgeConfig()
PAST = 4.0  # [mm] from the corner, where the next edge is taken up
EDGES = 100  # of an outline at most; two corners might send the pad to and fro
FRAMES = 16  # that a corner is seen in
SHORT = 2.0  # [mm] of travel, from which an edge is more than its corners
SAME = 1.0  # [mm] between two corners that are one
SEEN = 0.2  # [mm] standard deviation of a corner seen in one place
LOOKS = 3  # places that a corner is looked for from,
PART = 7.0  # [mm] about a corner, either way, in which it is looked for at last
STEP = 1.0  # [mm] one beyond the other: a hole's rim may hide it from one of them


@dataclass(frozen=True)
class TrackedOutline:
    """The edges of a face's outline, in order; false where none was tracked."""

    traces: tuple[EdgeTrace, ...]
    corners: Floats  # (n, 3) [mm] where two of them meet
    ended: Literal["closed", "lost", "length", "blocked"]
    travel: float  # [mm]
    forces: tuple[float, ...]  # [N] at every tick
    set_points: tuple[float, ...]  # [N] that were wanted
    profiles: tuple[EdgeProfile | None, ...] = ()  # across each edge
    fault: Fault | None = None  # that blocked it
    lead: int = 0  # of the traces, that come before the loop

    def __bool__(self) -> bool:
        return bool(self.traces)


def follow_outline(
    guard: Guard,
    along: Floats,
    length: float,
    touch: int,
    stroke: int,
    press: float = PRESS,
    config: EdgeConfig = DEFAULT,
) -> TrackedOutline:
    """Track the outline under the pad, the way of the (3,) world direction `along`, up to `length` [mm].

    It closes where it comes back to any place of its own; what was tracked until there leads in, and is no part.
    """
    outline = _Outline(length)
    try:
        _follow(outline, guard, along, touch, stroke, press, config)
    except (OverPress, Collision) as fault:
        outline.fault = fault
    edges, ended = outline.edges, outline.ended
    if ended == "lost" and outline.travel < 2.0 * config.clear:
        outline.drawn.clear()  # what was soon lost again was no edge
    traces = tuple(trace for trace, _ in outline.drawn)
    return TrackedOutline(
        traces,
        joins_of(traces),
        ended,
        outline.travel,
        tuple(force for edge in edges for force in edge.forces),
        tuple(force for edge in edges for force in edge.set_points),
        tuple(profile for _, profile in outline.drawn),
        outline.fault,
        outline.lead,
    )


@dataclass
class _Outline:
    """What is there when a fault ends it."""

    length: float  # [mm] at most
    edges: list[Tracked] = field(default_factory=list)
    drawn: list[tuple[EdgeTrace, EdgeProfile | None]] = field(default_factory=list)
    closed: bool = False  # at a corner that was met before
    lead: int = 0  # edges drawn before the loop that closed
    fault: Fault | None = None

    @property
    def travel(self) -> float:
        """[mm]."""
        return sum(edge.travel for edge in self.edges)

    @property
    def ended(self) -> Literal["closed", "lost", "length", "blocked"]:
        """How."""
        last = self.edges[-1].ended if self.edges else "lost"
        if self.fault is not None:
            return "blocked"
        if self.closed:
            return "closed"
        return "lost" if last == "corner" else last


def _follow(
    outline: _Outline,
    guard: Guard,
    along: Floats,
    touch: int,
    stroke: int,
    press: float,
    config: EdgeConfig,
) -> None:
    """Edge after edge, until it closes or ends."""
    edges, drawn = outline.edges, outline.drawn
    starts, corners = list[Start](), list[MetCorner]()
    met: Meeting | None = None
    heading: Floats | None = along
    while heading is not None and len(edges) < EDGES:
        gone = outline.travel
        homes = [start.home(gone, config.closing) for start in starts]
        number, left = stroke + len(edges), outline.length - gone
        edge = follow_edge(guard, heading, left, touch, number, press, config, homes)
        edges.append(edge)
        if edge.trace is not None:
            starts.append(Start(edge, edge.trace, len(drawn), gone))
            drawn.append((edge.trace, edge.profile))
        if edge.ended != "corner" or edge.last is None:
            outline.fault = edge.fault
            if edge.ended == "closed" and starts:
                _close(outline, starts[-1 if edge.home is None else edge.home], edge)
            break
        before, met = met, _turned(guard, edge, config)
        if met is not None:
            heading = met.along
        else:  # no two edges meet here: it was a bend
            heading = _onward(guard, edge.last) if edge.travel > config.clear else None
        hardly = edge.trace is None or (edge.travel < SHORT and len(drawn) > 1)
        if hardly and before is not None and met is not None:
            if edge.trace is not None:  # its corners say better how it runs
                starts.pop()
                drawn.pop()
            elif dist(before.point, met.point) < SAME:
                break
            if drawn:
                drawn.append((_short(before, met, drawn[-1][0], touch, number), None))
        if met is None:
            continue
        again = met_again(corners, met, outline.travel, config.closing)
        if again is not None:
            outline.closed, outline.lead = True, lead_of([trace for trace, _ in drawn], again, config.closing)
            break
        corners.append(MetCorner(met, len(drawn), outline.travel if corners else 0.0))


def _onward(guard: Guard, last: Followed) -> Floats:
    """(3,) the way that an edge went when it was last seen."""
    way: Floats = guard.world_from_sensor[:3, :2] @ last.direction
    return way


def _close(outline: _Outline, begun: Start, last: Tracked) -> None:
    """Draw the edge that a loop began on and the last once more, each run on by the other: it closes there."""
    outline.lead, drawn, first = begun.number, outline.drawn, begun.edge
    if first is last or not first.ticks or not last.ticks or last.trace is None:
        return
    begins = first.draw(leading_to(last.ticks, first.ticks[0]))
    ends = last.draw((), leading_from(first.ticks, last.ticks[-1]))
    if begins is not None and ends is not None:
        drawn[begun.number], drawn[-1] = (begins, first.profile), (ends, last.profile)


def _turned(guard: Guard, edge: Tracked, config: EdgeConfig) -> Meeting | None:
    """Move beside the edge that the last one meets; where it does, or None where none is seen."""
    last, corner = edge.last, edge.corner
    assert last is not None
    begun, onward = guard.world_from_sensor.copy(), _onward(guard, last)
    for look in range(LOOKS):
        if corner is not None:
            break
        if look:
            guard.go_to(se3.pose(begun[:3, :3], begun[:3, 3] + look * STEP * onward))
        seen = dwell(guard, FRAMES)
        corner = meeting(seen, last, config.corners)
        corner = corner or meeting(seen, last, config.corners, sure_lines(seen.image, 3))
        corner = corner or _in_part(seen, begun, last, config)
    if corner is None:
        guard.go_to(begun)
        return None
    here = guard.world_from_sensor
    past = PAST if edge.corner is None else 2.0 * PAST
    place = corner.point + past * corner.along + config.inside * corner.inward
    lift = float((place - here[:3, 3]) @ here[:3, 2])
    guard.go_to(se3.pose(here[:3, :3], place - lift * here[:3, 2]))
    return corner


def _in_part(seen: Observation, begun: Floats, last: Followed, config: EdgeConfig) -> Meeting | None:
    """The meeting in the part of the pad about where the last edge ended, which farther edges do not cross.

    `begun` (4, 4) is where the pad lay when it was last seen.
    """
    onward = min(last.ahead, last.opens)
    if not np.isfinite(onward):
        return None
    end = begun[:3, :2] @ (last.foot + onward * last.direction) + begun[:3, 3]
    place = (end - seen.world_from_sensor[:3, 3]) @ seen.world_from_sensor[:3, :2]
    part = window_about(seen, place, PART)
    return None if part is None else meeting(part, last, config.corners)


def _short(begins: Meeting, ends: Meeting, before: EdgeTrace, touch: int, stroke: int) -> EdgeTrace:
    """An edge too short to be followed: from one of its corners to the other."""
    points, normal = np.array([begins.point, ends.point]), before.normals[-1]
    points -= np.outer((points - before.points[-1]) @ normal, normal)  # off the pad, which is pressed in
    along = (points[1] - points[0]) / max(float(np.linalg.norm(points[1] - points[0])), 1e-9)
    normals = frozen(np.tile(normal, (2, 1)))
    return EdgeTrace(
        frozen(points), frozen([along, along]), normals, frozen([SEEN, SEEN]), False, touch, stroke
    )


def joins_of(traces: tuple[EdgeTrace, ...]) -> Floats:
    """(n, 3) [mm] where each edge of an outline comes nearest to the next."""
    return np.array([_meeting(a, b) for a, b in pairwise(traces)]).reshape(-1, 3)


def _meeting(before: EdgeTrace, after: EdgeTrace) -> Floats:
    """(3,) where the end of one trace and the start of the next, drawn on straight, come nearest."""
    a, u = before.points[-1], before.tangents[-1]
    b, v = after.points[0], after.tangents[0]
    system = np.stack([u, -v], axis=1)
    (s, t), *_ = np.linalg.lstsq(system, b - a, rcond=None)
    middle: Floats = 0.5 * (a + s * u + b + t * v)
    return middle
