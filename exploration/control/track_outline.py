"""Outline tracking: edge after edge round a face, turning at its corners, until it closes.

At a corner the next edge is the line under the pad that is not the last one, taken the way that keeps the material
on the same hand: a convex corner turns toward the material and an inside one away from it, by the same rule.
"""

from dataclasses import dataclass, field
from itertools import pairwise
from math import dist
from typing import Literal

import numpy as np

from exploration.control.closing import Home
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
    """Track the outline under the pad, the way of the (3,) world direction `along`, up to `length` [mm]."""
    outline = _Outline(length)
    try:
        _follow(outline, guard, along, touch, stroke, press, config)
    except (OverPress, Collision) as fault:
        outline.fault = fault
    edges, ended = outline.edges, outline.ended
    if ended == "lost" and sum(edge.travel for edge in edges) < 2.0 * config.clear:
        outline.drawn.clear()  # what was soon lost again was no edge
    traces = tuple(trace for trace, _ in outline.drawn)
    return TrackedOutline(
        traces,
        joins_of(traces),
        ended,
        sum(edge.travel for edge in edges),
        tuple(force for edge in edges for force in edge.forces),
        tuple(force for edge in edges for force in edge.set_points),
        tuple(profile for _, profile in outline.drawn),
        outline.fault,
    )


@dataclass
class _Outline:
    """What is there when a fault ends it."""

    length: float  # [mm] at most
    edges: list[Tracked] = field(default_factory=list)
    drawn: list[tuple[EdgeTrace, EdgeProfile | None]] = field(default_factory=list)
    closed: bool = False  # at the corner that was its first
    fault: Fault | None = None

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
    home: Home | None = None
    begun: Tracked | None = None
    first: Meeting | None = None
    met: Meeting | None = None
    heading: Floats | None = along
    while heading is not None and len(edges) < EDGES:
        left = outline.length - sum(edge.travel for edge in edges)
        edge = follow_edge(guard, heading, left, touch, stroke + len(edges), press, config, home)
        edges.append(edge)
        if edge.trace is not None:
            drawn.append((edge.trace, edge.profile))
            begun = begun or edge
            home = home or Home(edge.trace.points[0], edge.trace.tangents[0])
        if edge.ended != "corner" or edge.last is None:
            outline.fault = edge.fault
            if begun is not None and edge.ended == "closed" and edge is not begun:
                _run_on(drawn, begun, edge)
            break
        before, met = met, _turned(guard, edge, config)
        if met is not None:
            heading = met.along
        else:  # no two edges meet here: it was a bend
            heading = _onward(guard, edge.last) if edge.travel > config.clear else None
        if edge.trace is None and before is not None and met is not None:
            if dist(before.point, met.point) < SAME:
                break
            if drawn:
                drawn.append((_short(before, met, drawn[-1][0], touch, stroke + len(edges) - 1), None))
        gone = sum(edge.travel for edge in edges) > config.closing.least_loop
        if gone and first is not None and met is not None and _again(first, met, config):
            outline.closed = True
            break
        first = first or met


def _onward(guard: Guard, last: Followed) -> Floats:
    """(3,) the way that an edge went when it was last seen."""
    way: Floats = guard.world_from_sensor[:3, :2] @ last.direction
    return way


def _run_on(drawn: list[tuple[EdgeTrace, EdgeProfile | None]], first: Tracked, last: Tracked) -> None:
    """Draw the first edge and the last once more, each run on by the other: the outline closes along them."""
    if not first.ticks or not last.ticks:
        return
    begins = first.draw(leading_to(last.ticks, first.ticks[0]))
    ends = last.draw((), leading_from(first.ticks, last.ticks[-1]))
    if begins is not None and ends is not None:
        drawn[0], drawn[-1] = (begins, first.profile), (ends, last.profile)


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


def _again(first: Meeting, met: Meeting, config: EdgeConfig) -> bool:
    """Whether a corner is the first one, come to again."""
    return dist(first.point, met.point) < config.closing.aside and float(first.along @ met.along) > 0.8


def _short(begins: Meeting, ends: Meeting, before: EdgeTrace, touch: int, stroke: int) -> EdgeTrace:
    """An edge too short to be followed: from one of its corners to the other."""
    points = np.array([begins.point, ends.point])
    along = (points[1] - points[0]) / max(float(np.linalg.norm(points[1] - points[0])), 1e-9)
    normals = frozen(np.tile(before.normals[-1], (2, 1)))
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
