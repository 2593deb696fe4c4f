"""What a tracked outline is: straight and round edges, their lengths, angles and radii, and where they meet.

A circle is fitted to n points of its plane by least squares of their distances, c and r minimizing
sum (|p - c| - r)^2, by Gauss and Newton's steps from Kasa's algebraic circle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import dist
from typing import Any, Literal, TypeVar

import numpy as np

from exploration.sensing.lines.edge_rounding import Rounding
from primitives.arrays import Floats, frozen
from primitives.evidence import EdgeTrace

Curve = Literal["line", "circle", "other"]
_Felt = TypeVar("_Felt")


@dataclass(frozen=True)
class TracedConfig:
    """When a trace counts as straight or round."""

    straight: float = 0.05  # [mm] rms off a line, that a straight edge may have
    better: float = 2.0  # times by which a circle must fit better than a line
    round: float = 0.8  # of its circle, that a closed trace must have run along
    on_curve: float = 0.1  # [mm] rms off a line or circle, beyond which an edge is neither


@dataclass(frozen=True)
class TracedEdge:
    """One tracked edge, described."""

    curve: Curve
    length: float  # [mm]
    rms: float  # [mm] off the line or circle
    direction: Floats  # (3,) unit: along a line, or a circle's axis; the mean normal else
    center: Floats | None = None  # (3,) [mm] of a circle
    radius: float | None = None  # [mm] of a circle
    dihedral: float | None = None  # [rad] through the material
    rounding: Rounding | None = None

    def as_json(self) -> dict[str, Any]:
        """As `found` lists it."""
        return {
            "curve": self.curve,
            "length_mm": self.length,
            "rms_mm": self.rms,
            "direction": self.direction,
            "center_mm": self.center,
            "radius_mm": self.radius,
            "dihedral_deg": None if self.dihedral is None else float(np.degrees(self.dihedral)),
            "rounding_mm": None if self.rounding is None else self.rounding.radius,
            "rounding_sigma_mm": None if self.rounding is None else self.rounding.sigma,
        }


def described(
    trace: EdgeTrace, dihedral: float | None = None, config: TracedConfig = TracedConfig()
) -> TracedEdge:
    """What curve a trace runs along."""
    points = trace.points
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    normal = trace.normals.mean(axis=0)
    normal = normal / np.linalg.norm(normal)
    middle = points.mean(axis=0)
    along = np.linalg.svd(points - middle, full_matrices=False)[2][0]
    along = along * (1.0 if (points[-1] - points[0]) @ along >= 0 else -1.0)
    off = points - middle
    off_line = float(np.sqrt(np.mean(np.sum((off - np.outer(off @ along, along)) ** 2, axis=1))))
    if len(points) < 5:
        return TracedEdge("line", length, off_line, along, dihedral=dihedral)
    center, radius, axis, off_circle = circle_through(points, normal)
    round_ = trace.closed and length > config.round * 2.0 * np.pi * radius
    if not round_ and off_line < max(config.straight, config.better * off_circle):
        return TracedEdge("line", length, off_line, along, dihedral=dihedral)
    if off_circle < config.on_curve:
        length = 2.0 * np.pi * radius if round_ else length  # the start is passed by a little
        return TracedEdge("circle", length, off_circle, axis, center, radius, dihedral)
    return TracedEdge("other", length, min(off_line, off_circle), normal, dihedral=dihedral)


def circle_through(points: Floats, toward: Floats, steps: int = 20) -> tuple[Floats, float, Floats, float]:
    """Center, radius, axis on the side of `toward`, and rms [mm], of the circle nearest to (n, 3) points."""
    middle = points.mean(axis=0)
    frame = np.linalg.svd(points - middle, full_matrices=False)[2]
    flat = (points - middle) @ frame.T
    system = np.column_stack([2.0 * flat[:, :2], np.ones(len(flat))])
    x, y, c = np.linalg.lstsq(system, (flat[:, :2] ** 2).sum(axis=1), rcond=None)[0]
    place = np.array([x, y, np.sqrt(max(c + x * x + y * y, 1e-12))])
    for _ in range(steps):
        away = flat[:, :2] - place[:2]
        distance = np.maximum(np.linalg.norm(away, axis=1), 1e-9)
        slopes = np.column_stack([-away / distance[:, None], -np.ones(len(flat))])
        step = np.linalg.lstsq(slopes, place[2] - distance, rcond=None)[0]
        place = place + step
        if float(np.abs(step).max()) < 1e-9:
            break
    off = np.hypot(np.linalg.norm(flat[:, :2] - place[:2], axis=1) - place[2], flat[:, 2])
    axis = frame[2] * (1.0 if frame[2] @ toward >= 0 else -1.0)
    center: Floats = middle + place[0] * frame[0] + place[1] * frame[1]
    return center, float(place[2]), axis, float(np.sqrt(np.mean(off**2)))


def outward_of(trace: EdgeTrace, outward: Floats, tangent: Floats) -> Floats:
    """(n, 3) unit directions out of the material, on the hand where `outward` lies of `tangent` at the start."""
    across = np.cross(trace.tangents, trace.normals)
    hand = 1.0 if float(np.cross(tangent, trace.normals[0]) @ outward) > 0 else -1.0
    turned: Floats = hand * across / np.linalg.norm(across, axis=1, keepdims=True)
    return turned


def angles_between(traces: Sequence[EdgeTrace], closed: bool) -> list[float]:
    """[rad] between each edge and the next, pi where they go straight on."""
    pairs = list(pairwise(traces))
    if closed and len(traces) > 2:
        pairs.append((traces[-1], traces[0]))
    turns = [_direction(a, -1) @ _direction(b, 0) for a, b in pairs]
    return [float(np.pi - np.arccos(np.clip(turn, -1.0, 1.0))) for turn in turns]


def _direction(trace: EdgeTrace, end: int) -> Floats:
    """(3,) at one end of an edge; a straight one's is that of the whole."""
    return _drawn_on(trace, end)[1]


def _drawn_on(trace: EdgeTrace, end: int) -> tuple[Floats, Floats]:
    """Point and (3,) direction of the line that goes on at one end of an edge; a straight one's is its own."""
    edge = described(trace)
    if edge.curve == "line":
        return trace.points.mean(axis=0), edge.direction
    return trace.points[end], trace.tangents[end]


def comes_round(traces: Sequence[EdgeTrace]) -> bool:
    """Whether an outline turned back somewhere, as a loop must: the tangents of one, by length, add up to 0."""
    return bool(traces) and bool(
        (np.concatenate([t.tangents for t in traces]) @ traces[0].tangents[0] < 0).any()
    )


def loop_gap(traces: Sequence[EdgeTrace], reach: float = 6.0) -> float | None:
    """[mm] across the edge, between where a closed outline begins and where it comes by there again.

    None where it does not, within `reach` [mm] along the edge.
    """
    start, along, last = traces[0].points[0], traces[0].tangents[0], traces[-1].points
    steps = np.linalg.norm(np.diff(last, axis=0), axis=1)
    left = np.append(np.cumsum(steps[::-1])[::-1], 0.0)
    off = last[left < 2.0 * reach] - start
    ahead = off @ along
    near = np.abs(ahead) < reach
    if not near.any():
        return None
    aside = off[near] - np.outer(ahead[near], along)
    order = np.argsort(ahead[near])
    if ahead[near].min() < 0.0 < ahead[near].max():
        passing = [np.interp(0.0, ahead[near][order], column) for column in aside[order].T]
        return float(np.linalg.norm(passing))
    return float(np.linalg.norm(aside, axis=1).min())


def whole_edges(
    traces: Sequence[EdgeTrace], felt: Sequence[_Felt | None], closed: bool, straight_on: float = 0.3
) -> list[tuple[EdgeTrace, _Felt | None]]:
    """The edges of an outline, each with what was felt of it.

    Where it closed along the edge that it began on, the two parts of that are one.  `straight_on` [rad] is the
    least angle between two edges.
    """
    edges = list(zip(traces, felt, strict=True))
    if not closed or len(edges) < 2:
        return edges
    (first, known), (last, other) = edges[0], edges[-1]
    if float(last.tangents[-1] @ first.tangents[0]) < np.cos(straight_on):
        return edges
    joined = as_one(last, first)
    return [(joined, other if known is None else known), *edges[1:-1]]


def as_one(before: EdgeTrace, after: EdgeTrace) -> EdgeTrace:
    """One edge of two that run the same way: all of `after`, and what of `before` lies behind where it begins."""
    behind = (before.points - after.points[0]) @ after.tangents[0] < 0.0
    return replace(
        after,
        points=_joined(before.points[behind], after.points),
        tangents=_joined(before.tangents[behind], after.tangents),
        normals=_joined(before.normals[behind], after.normals),
        sigma=_joined(before.sigma[behind], after.sigma),
    )


def corners_of(traces: Sequence[EdgeTrace], closed: bool) -> Floats:
    """(n, 3) [mm] where each edge, drawn on straight, comes nearest to the next; closed: the last to the first."""
    following = [*pairwise(traces), *([(traces[-1], traces[0])] if closed and len(traces) > 1 else [])]
    return np.array([_meeting(a, b) for a, b in following]).reshape(-1, 3)


def from_corner_to_corner(
    edges: Sequence[TracedEdge], corners: Floats, between: Sequence[float], straight_on: float = 0.3
) -> list[TracedEdge]:
    """Edges whose straight ones are as long as their corners lie apart: a trace ends short of those.

    `corners` and the angles [rad] `between` the edges are as `corners_of` and `angles_between` tell them.  In an
    open outline the first edge and the last have no corner at one end, and edges that go `straight_on` [rad] meet
    in no certain place.
    """
    if len(corners) == len(edges) > 1:
        apart = dict(enumerate(np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1).tolist()))
    else:
        sharp = [np.pi - angle > straight_on for angle in between]
        apart = {
            k: dist(corners[k - 1], corners[k]) for k in range(1, len(corners)) if sharp[k - 1] and sharp[k]
        }
    return [
        replace(edge, length=apart[k]) if edge.curve == "line" and k in apart else edge
        for k, edge in enumerate(edges)
    ]


def gaps_of(
    traces: Sequence[EdgeTrace], corners: Floats, between: Sequence[float], straight_on: float = 0.3
) -> list[float]:
    """[mm] that were not followed from each edge to the next, by way of their corner where they meet in one.

    `corners`, `between` and `straight_on` as for `from_corner_to_corner`.
    """
    pairs = zip([*pairwise(traces), (traces[-1], traces[0])], corners, between, strict=False)
    return [
        dist(a.points[-1], corner) + dist(corner, b.points[0])
        if np.pi - angle > straight_on
        else dist(a.points[-1], b.points[0])
        for (a, b), corner, angle in pairs
    ]


def _meeting(before: EdgeTrace, after: EdgeTrace) -> Floats:
    (a, u), (b, v) = _drawn_on(before, -1), _drawn_on(after, 0)
    (s, t), *_ = np.linalg.lstsq(np.stack([u, -v], axis=1), b - a, rcond=None)
    middle: Floats = 0.5 * (a + s * u + b + t * v)
    return middle


def _joined(before: Floats, after: Floats) -> Floats:
    return frozen(np.concatenate([before, after]))
