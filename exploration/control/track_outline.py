"""Outline tracking: edge after edge round a face, turning at its corners, until it closes.

At a corner the next edge is the line under the pad that is not the last one, taken the way that keeps the material
on the same hand: a convex corner turns toward the material and an inside one away from it, by the same rule.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from exploration.control.corners import meeting
from exploration.control.dwell import dwell
from exploration.control.edge_profile import EdgeProfile
from exploration.control.hybrid import PRESS
from exploration.control.track_edge import EdgeConfig, Home, Tracked, follow_edge
from exploration.devices.guard import Guard
from exploration.sensing.lines.hough import sure_lines
from primitives import pose as se3
from primitives.arrays import Floats
from primitives.evidence import EdgeTrace

DEFAULT = EdgeConfig()
PAST = 4.0  # [mm] from the corner, where the next edge is taken up


@dataclass(frozen=True)
class TrackedOutline:
    """The edges of a face's outline, in order; false where none was tracked."""

    traces: tuple[EdgeTrace, ...]
    corners: Floats  # (n, 3) [mm] where two of them meet
    ended: Literal["closed", "lost", "length"]
    travel: float  # [mm]
    forces: tuple[float, ...]  # [N] at every tick
    set_points: tuple[float, ...]  # [N] that were wanted
    profiles: tuple[EdgeProfile | None, ...] = ()  # across each edge

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
    edges: list[Tracked] = []
    home: Home | None = None
    heading: Floats | None = along
    while heading is not None:
        left = length - sum(edge.travel for edge in edges)
        edge = follow_edge(guard, heading, left, touch, stroke + len(edges), press, config, home)
        edges.append(edge)
        if edge.ended != "corner" or edge.last is None:
            break
        if home is None and edge.trace is not None:
            home = Home(edge.trace.points[0], edge.trace.tangents[0])
        heading = _turned(guard, edge, config)
    last = edges[-1].ended
    seen = [edge for edge in edges if edge.trace is not None]
    traces = tuple(edge.trace for edge in seen if edge.trace is not None)
    return TrackedOutline(
        traces,
        np.array([_meeting(a, b) for a, b in pairwise(traces)]).reshape(-1, 3),
        last if last in ("closed", "length") else "lost",
        sum(edge.travel for edge in edges),
        tuple(force for edge in edges for force in edge.forces),
        tuple(force for edge in edges for force in edge.set_points),
        tuple(edge.profile for edge in seen),
    )


def _turned(guard: Guard, edge: Tracked, config: EdgeConfig) -> Floats | None:
    """Move beside the edge that the last one meets; its (3,) world direction, or None where none is seen."""
    seen = dwell(guard, 4)
    last = edge.last
    assert last is not None
    here = seen.world_from_sensor
    corner = edge.corner or meeting(seen, last, config.corners)
    corner = corner or meeting(seen, last, config.corners, sure_lines(seen.image, 3))
    if corner is None:
        return None
    past = PAST if edge.corner is None else 2.0 * PAST
    place = corner.point + past * corner.along + config.inside * corner.inward
    lift = float((place - here[:3, 3]) @ here[:3, 2])
    guard.go_to(se3.pose(here[:3, :3], place - lift * here[:3, 2]))
    return corner.along


def _meeting(before: EdgeTrace, after: EdgeTrace) -> Floats:
    """(3,) where the end of one trace and the start of the next, drawn on straight, come nearest."""
    a, u = before.points[-1], before.tangents[-1]
    b, v = after.points[0], after.tangents[0]
    system = np.stack([u, -v], axis=1)
    (s, t), *_ = np.linalg.lstsq(system, b - a, rcond=None)
    middle: Floats = 0.5 * (a + s * u + b + t * v)
    return middle
