"""`palpate track edge`: find the object, come to an edge, follow the outline of its face, feel behind the edges.

Stroke, lie over, follow, roll over: each step is the tracker's own; the object is not asked.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from exploration.control.edge_profile import EdgeProfile
from exploration.control.hybrid import PRESS
from exploration.control.sighting import Sighting
from exploration.control.track_edge import EdgeConfig
from exploration.control.track_outline import TrackedOutline, follow_outline
from exploration.devices.guard import Collision, OverPress
from exploration.planning.moves.edge_from_face import NoEdge, dihedral, lie_over, pressed, reach_edge
from exploration.planning.touching.pad import TouchesSpent
from exploration.sensing.lines.edge_rounding import Rounding, rounding_of
from exploration.sensing.response import Response, rubber
from primitives.arrays import Floats
from primitives.errors import PalpateError
from primitives.evidence import EdgeTrace
from recognition.running.felt_run import FeltRun
from recognition.tracking.both_ways import followed_both_ways
from recognition.tracking.falling_face import set_back
from recognition.tracking.sharp_turns import split_at_corners
from recognition.tracking.traced import (
    angles_between,
    comes_round,
    corners_of,
    described,
    from_corner_to_corner,
    gaps_of,
    loop_gap,
    outward_of,
    whole_edges,
)

Say = Callable[[str], None]


@dataclass(frozen=True)
class TrackEdgeConfig:
    """How much is followed and felt."""

    longest: float = 2000.0  # [mm] of an outline, either way
    places: int = 3  # of the object, that an edge is come to from
    dihedrals: int = 12  # edges behind which the face is felt
    press: float = PRESS  # [mm]
    jumped: float = 10.0  # [mm] about a corner that are not followed, from which that is told
    share: float = 0.5  # of an outline, that such corners may be where it closed


@dataclass(frozen=True)
class EdgeTrack:
    """An outline, and what it is; false where no edge was."""

    traces: tuple[EdgeTrace, ...] = ()
    ended: str = "no edge"  # or closed, lost, length, blocked
    why: str = ""  # nothing was tracked
    dihedrals: tuple[float | None, ...] = ()  # [rad] of every edge
    roundings: tuple[Rounding | None, ...] = ()
    forces: tuple[float, ...] = ()  # [N] at every tick
    set_points: tuple[float, ...] = ()  # [N]
    travel: float = 0.0  # [mm]
    lead: tuple[EdgeTrace, ...] = ()  # followed before the outline that closed, and no part of it

    def __bool__(self) -> bool:
        return bool(self.traces)

    @property
    def points(self) -> Floats:
        """(n, 3) [mm] of all edges, in order."""
        return np.concatenate([np.empty((0, 3)), *(trace.points for trace in self.traces)])

    @property
    def normals(self) -> Floats:
        """(n, 3) of the face, outward."""
        return np.concatenate([np.empty((0, 3)), *(trace.normals for trace in self.traces)])

    @property
    def sigma(self) -> Floats:
        """(n,) [mm] across the edge."""
        return np.concatenate([np.empty(0), *(trace.sigma for trace in self.traces)])

    @property
    def dihedral(self) -> float | None:
        """[rad] of the first edge whose other face was felt."""
        return next((angle for angle in self.dihedrals if angle is not None), None)

    @property
    def gap(self) -> float | None:
        """[mm] across the outline, between its end and its start, where it closed."""
        return loop_gap(self.traces) if self.ended == "closed" else None

    def found(self) -> dict[str, Any]:
        """As the summary's `found`."""
        closed = self.ended == "closed"
        whole = whole_edges(self.traces, self.dihedrals, closed)
        corners = corners_of([trace for trace, _ in whole], closed)
        rounded = [rounding for _, rounding in whole_edges(self.traces, self.roundings, closed)]
        edges = [
            replace(described(trace, angle), rounding=rounding)
            for (trace, angle), rounding in zip(whole, rounded, strict=True)
        ]
        between = angles_between([trace for trace, _ in whole], closed)
        edges = from_corner_to_corner(edges, corners, between)
        normal = self.normals.mean(axis=0) if len(self.normals) else None
        share = np.abs(np.array(self.forces) / np.array(self.set_points) - 1.0) < 0.1
        return {
            "ended": self.ended,
            "edges": [edge.as_json() for edge in edges],
            "corners_mm": corners,
            "angles_between_deg": np.degrees(between).tolist(),
            "face_normal": None if normal is None else normal / np.linalg.norm(normal),
            "length_mm": sum(edge.length for edge in edges),
            "loop_gap_mm": self.gap,
            "lead_in": [described(trace).as_json() for trace in self.lead],
            "force_set_n": float(np.median(self.set_points)) if self.set_points else None,
            "force_within_10_percent": float(share.mean()) if len(share) else None,
        }


def track_edge(run: FeltRun, speed: float, say: Say, config: TrackEdgeConfig | None = None) -> EdgeTrack:
    """Find an edge of the object and follow the outline that it belongs to, at `speed` [mm/s].

    Where nothing can be followed from one place of the object, or is lost, it is found again in another; the
    outline that closed is kept, or the longest.
    """
    config, tracks = config or TrackEdgeConfig(), list[EdgeTrack]()
    say("looking for the object")
    run.find()
    for left in reversed(range(config.places)):
        say("looking for an edge")
        edge = _come_to(run)
        if isinstance(edge, NoEdge):
            tracks.append(EdgeTrack(why=edge.reason))
            left = 0 if edge.round else left
        else:
            tracks.append(_followed(run, edge, speed, say, config))
        if not left or (tracks[-1] and tracks[-1].ended != "lost"):
            break
        say("looking for another place")
        try:
            run.find_elsewhere()
        except PalpateError:
            break
    return max(reversed(tracks), key=lambda track: (track.ended == "closed", len(track.points)))


def _come_to(run: FeltRun) -> Sighting | NoEdge:
    """An edge that is come to from where the pad lies, and then lies over."""
    try:
        edge = reach_edge(run.pad)
        if edge:
            lie_over(run.pad, edge)
        return edge
    except TouchesSpent as spent:
        return NoEdge(f"none was come to, and {spent}; raise --max-touches")
    except (OverPress, Collision) as fault:
        return NoEdge(f"none was come to, and the pad backed off ({fault})")


def _followed(run: FeltRun, edge: Sighting, speed: float, say: Say, config: TrackEdgeConfig) -> EdgeTrack:
    """The outline that an edge under the pad belongs to."""
    say("following the edge")
    cost = run.guard.cost

    def follow(along: Floats) -> TrackedOutline:
        cost.strokes += 1
        servo = EdgeConfig(speed=speed, curvatures=edge.curvatures)
        told = (config.longest, cost.touches, cost.strokes, config.press, servo)
        return follow_outline(run.guard, along, *told)

    outline = followed_both_ways(run.guard, edge.tangent, follow)
    if outline.fault is not None:
        run.warnings.append("the pad ran into something beside the edge, and backed off")
    run.announce("outline", {"ended": outline.ended, "edges": len(outline.traces)})
    if not outline:
        why = "the edge that was seen could not be followed" if outline.fault is None else str(outline.fault)
        return EdgeTrack(why=why, ended=outline.ended)
    press = _pressed(run) or config.press
    run.pad.lie(np.empty((0, 3)))
    return _felt_behind(run, outline, edge, press, say, config)


def _pressed(run: FeltRun) -> float | None:
    """[mm] to which the face is pressed where the outline ended."""
    try:
        return pressed(run.pad)
    except (OverPress, Collision) as error:
        run.warnings.append(str(error))
        return None


def _felt_behind(
    run: FeltRun, outline: TrackedOutline, edge: Sighting, press: float, say: Say, config: TrackEdgeConfig
) -> EdgeTrack:
    """The outline with its dihedral angles, and set back by what they did to it, pressed `press` [mm]."""
    outline = split_at_corners(outline)
    traces, angles, response = [], [], _response(run)
    lead, loop = outline.traces[: outline.lead], outline.traces[outline.lead :]
    for number, trace in enumerate(loop):
        outward = outward_of(trace, edge.outward, edge.tangent)
        angle = None
        if number < config.dihedrals:
            say(f"feeling behind edge {number + 1} of {len(loop)}")
            angle = _dihedral(run, trace, outward)
        angles.append(angle)
        if angle is not None:
            trace = set_back(trace, outward, angle, press, response, response.mean_width)
        traces.append(trace)
    profiles = zip(outline.profiles[outline.lead :], angles, strict=True)
    roundings = [_rounding(run, profile, angle) for profile, angle in profiles]
    if poor := sum(rounding is not None and not rounding for rounding in roundings):
        run.warnings.append(
            f"no rounding is told of {poor} of the edges: none explains the depth across them"
        )
    if lead:
        length = sum(described(trace).length for trace in lead)
        run.warnings.append(
            f"the first {length:.0f} mm that were followed are no part of the outline that closed"
        )
    ended = outline.ended
    if ended == "closed" and not (comes_round(loop) and _hangs_together(run, traces, config)):
        ended = "lost"
    return EdgeTrack(
        tuple(traces),
        ended,
        dihedrals=tuple(angles),
        roundings=tuple(rounding or None for rounding in roundings),
        forces=outline.forces,
        set_points=outline.set_points,
        travel=outline.travel,
        lead=lead,
    )


def _hangs_together(run: FeltRun, traces: list[EdgeTrace], config: TrackEdgeConfig) -> bool:
    """Whether a loop was followed but for small gaps; greater ones are told, as of tips that the pad jumped."""
    whole = [trace for trace, _ in whole_edges(traces, [None] * len(traces), True)]
    gaps = gaps_of(whole, corners_of(whole, True), angles_between(whole, True))
    if jumped := [gap for gap in gaps if gap > config.jumped]:
        told = f"{len(jumped)} of the corners were jumped, up to {max(jumped):.1f} mm about one not followed"
        run.warnings.append(f"{told}: their edges are drawn on")
    return sum(jumped) < config.share * (sum(described(trace).length for trace in whole) + sum(gaps))


def _rounding(run: FeltRun, profile: EdgeProfile | None, dihedral: float | None) -> Rounding | None:
    """How an edge is rounded whose dihedral angle [rad] was felt."""
    if profile is None or dihedral is None:
        return None
    calibration, response = run.guard.calibrations[run.guard.active], _response(run)
    known = calibration.spread_sigma * calibration.spread / profile.width
    return rounding_of(profile.place, profile.depth, profile.sigma, profile.width, response, dihedral, known)


def _response(run: FeltRun) -> Response:
    calibration = run.guard.calibrations[run.guard.active]
    return calibration.response or rubber(calibration.spread, run.guard.sensor.array.pitch)


def _dihedral(run: FeltRun, trace: EdgeTrace, outward: Floats) -> float | None:
    """[rad] at the trace's middle."""
    k = len(trace.points) // 2
    place = Sighting(
        trace.points[k],
        trace.tangents[k],
        outward[k],
        trace.normals[k],
        float(trace.sigma[k]),
        float(np.linalg.norm(np.diff(trace.points, axis=0), axis=1).sum()),
    )
    try:
        return dihedral(run.pad, replace(place, tangent=np.cross(place.outward, place.normal)))
    except (OverPress, Collision, TouchesSpent) as error:
        run.warnings.append(str(error))
        return None
