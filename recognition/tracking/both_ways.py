"""An outline followed one way and, where something ends it before it comes round, from its start the other way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import dist

from exploration.control.procedures.approach import retreat
from exploration.control.track_outline import TrackedOutline, joins_of
from exploration.devices.guard import Collision, Guard, Observation, OverPress
from primitives import pose as se3
from primitives.arrays import Floats, frozen
from primitives.evidence import EdgeTrace
from recognition.tracking.traced import as_one

LIFT = 3.0  # [mm] over the face, on the way back
STEP = 4.0  # [mm] between the places of that way

Follow = Callable[[Floats], TrackedOutline]  # the way of a (3,) world direction


def followed_both_ways(guard: Guard, along: Floats, follow: Follow) -> TrackedOutline:
    """The outline of the edge under the pad, first the way of the (3,) world direction `along`."""
    gone = [guard.world_from_sensor.copy()]

    def note(seen: Observation) -> None:
        if dist(seen.world_from_sensor[:3, 3], gone[-1][:3, 3]) > STEP:
            gone.append(seen.world_from_sensor.copy())

    watching = guard.observers
    guard.observers = (*watching, note)
    try:
        outline = follow(along)
    finally:
        guard.observers = watching
    if not outline or outline.ended in ("closed", "length"):
        return outline
    try:
        _back(guard, gone)
        other = follow(-along)
    except (OverPress, Collision):
        return outline
    return joined(other, outline) if other else outline


def joined(before: TrackedOutline, after: TrackedOutline) -> TrackedOutline:
    """One outline of two that were followed from one place on an edge, `before` against the way of `after`."""
    if before.ended == "closed":
        return before
    back = [_reversed(trace) for trace in reversed(before.traces)]
    one, two = back[-1], after.traces[0]
    if float(one.tangents[-1] @ two.tangents[0]) > 0.0:
        two = as_one(one, two)
    traces = (*back[:-1], two, *after.traces[1:])
    return TrackedOutline(
        traces,
        joins_of(traces),
        after.ended,
        before.travel + after.travel,
        (*before.forces, *after.forces),
        (*before.set_points, *after.set_points),
        (*before.profiles[:0:-1], *after.profiles),
        after.fault or before.fault,
    )


def _reversed(trace: EdgeTrace) -> EdgeTrace:
    return replace(
        trace,
        points=frozen(trace.points[::-1]),
        tangents=frozen(-trace.tangents[::-1]),
        normals=frozen(trace.normals[::-1]),
        sigma=frozen(trace.sigma[::-1]),
    )


def _back(guard: Guard, gone: list[Floats]) -> None:
    """Over the face the way that the pad came, and down to where it began: beside that way walls may stand."""
    retreat(guard, LIFT)
    over = se3.pose(translation=[0.0, 0.0, -LIFT])
    for place in reversed(gone):
        guard.go_to(place @ over)
    guard.go_to(gone[0])
