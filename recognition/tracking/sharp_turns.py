"""Traces that turn sharply are several edges: the tracker follows a blunt or inside corner as if it were a bend.

Two lines are fitted beside a place, to either side of the bend.  A trace that is smoothed along itself with a
standard deviation s passes a sharp corner, at which it turns by beta, sqrt(2 / pi) s sin(beta / 2) from where
the lines meet (our derivation).  An arc passes it farther away, by r (1 / cos(beta / 2) - 1), and where it is
long the lines are but chords of it: they meet farther off still.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from exploration.control.track_outline import TrackedOutline, joins_of
from primitives.arrays import Bools, Floats, frozen
from primitives.evidence import EdgeTrace


@dataclass(frozen=True)
class SharpTurnConfig:
    """What is a corner of a trace."""

    about: float = 3.0  # [mm] either way, which are rounded
    run: float = 6.0  # [mm] beyond those, either way, that are straight,
    least: int = 4  # points of a trace that may be fewer than that
    straight: float = 0.06  # [mm] rms off a line
    turns: float = 0.35  # [rad]
    smoothed: float = 0.9  # [mm] standard deviation, as traces at most are
    slack: float = 0.05  # [mm] by which the lines may meet farther off


def split_at_corners(outline: TrackedOutline, config: SharpTurnConfig = SharpTurnConfig()) -> TrackedOutline:
    """The outline with its traces split where they turn sharply; the profile of a whole says nothing of a part."""
    pieces = [split(trace, config) for trace in outline.traces]
    traces = tuple(piece for parts in pieces for piece in parts)
    profiles = tuple(
        profile if len(parts) == 1 else None
        for parts, profile in zip(pieces, outline.profiles, strict=True)
        for _ in parts
    )
    lead = sum(len(parts) for parts in pieces[: outline.lead])
    return replace(outline, traces=traces, corners=joins_of(traces), profiles=profiles, lead=lead)


def split(trace: EdgeTrace, config: SharpTurnConfig = SharpTurnConfig()) -> list[EdgeTrace]:
    """The pieces of a trace between its sharp corners; itself where it has none."""
    steps = np.linalg.norm(np.diff(trace.points, axis=0), axis=1)
    travel = np.append(0.0, np.cumsum(steps))
    turns = _turns(trace.points, travel, config)
    if not turns:
        return [trace]
    ends = [-np.inf, *turns, np.inf]
    pieces = []
    for begin, end in pairwise(ends):
        within = (travel > begin + config.about) & (travel < end - config.about)
        pieces.append(_some(trace, within))
    return [piece for piece in pieces if len(piece.points) >= config.least] or [trace]


def _turns(points: Floats, travel: Floats, config: SharpTurnConfig) -> list[float]:
    """[mm] of travel at which a trace turns sharply: of places side by side, the one nearest to its corner."""
    found: list[tuple[float, float]] = []  # travel, and how far from the corner
    for at in travel.tolist():
        missed = _missed(points, travel, at, config)
        if missed is None:
            continue
        if found and at - found[-1][0] < 2.0 * config.about:
            found[-1] = min(found[-1], (at, missed), key=lambda place: place[1])
        else:
            found.append((at, missed))
    return [at for at, _ in found]


def _missed(points: Floats, travel: Floats, at: float, config: SharpTurnConfig) -> float | None:
    """[mm] from a place on a trace to the sharp corner there; None where there is none."""
    past = travel - at
    before = (past < -config.about) & (past > -config.about - config.run)
    after = (past > config.about) & (past < config.about + config.run)
    if min(before.sum(), after.sum()) < config.least:
        return None
    (a, u, off_a), (b, v, off_b) = _line(points[before]), _line(points[after])
    turn = float(np.arccos(np.clip(u @ v, -1.0, 1.0)))
    if max(off_a, off_b) > config.straight or turn < config.turns:
        return None
    (s, t), *_ = np.linalg.lstsq(np.stack([u, -v], axis=1), b - a, rcond=None)
    corner = 0.5 * (a + s * u + b + t * v)
    near = float(np.linalg.norm(points - corner, axis=1).min())
    if near > np.sqrt(2.0 / np.pi) * config.smoothed * np.sin(0.5 * turn) + config.slack:
        return None
    return float(np.linalg.norm(points[np.abs(past).argmin()] - corner))


def _line(points: Floats) -> tuple[Floats, Floats, float]:
    """Middle, (3,) unit direction and rms [mm] of the line through some points in order."""
    middle = points.mean(axis=0)
    along = np.linalg.svd(points - middle, full_matrices=False)[2][0]
    along = along * np.sign((points[-1] - points[0]) @ along)
    off = points - middle
    rms = float(np.sqrt(np.mean(np.sum((off - np.outer(off @ along, along)) ** 2, axis=1))))
    return middle, along, rms


def _some(trace: EdgeTrace, which: Bools) -> EdgeTrace:
    return replace(
        trace,
        points=frozen(trace.points[which]),
        tangents=frozen(trace.tangents[which]),
        normals=frozen(trace.normals[which]),
        sigma=frozen(trace.sigma[which]),
        closed=False,
    )
