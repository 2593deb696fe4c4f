"""Approaches that might be worth making: from all sides at the middle, at likely surfaces, and where rivals
differ.

Directions all round are a Fibonacci lattice.  Where two likely objects at their poses differ, a place of one
that is far from the surface of the other is one that a touch can tell them apart by; it is aimed at along its
own normal, and at its nearest rim, along the normal of the face beside: the wall of a hole is felt from there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.distance import cdist

from exploration.planning.touching.lone_touch import Approach
from exploration.planning.ways.round_ball import Ball
from models.library import Library
from primitives import pose as se3
from primitives.arrays import Floats, Ints
from recognition.matching.next_touch.held import Held


@dataclass(frozen=True)
class CandidateConfig:
    """How many approaches are looked at."""

    around: int = 24  # directions
    aside: int = 1  # of each, at places off the middle
    off: float = 0.4  # of the ball's radius
    surfaces: int = 44  # places on likely surfaces
    pairs: int = 4  # of rivals
    differing: int = 9  # places of each, in which a pair differs
    beside: float = 0.5  # cosine between the normals of faces that meet in a rim, at most
    apart: float = 0.6  # [mm] from the other's surface, to differ


def directions(count: int) -> Floats:
    """(n, 3) unit vectors, even on the sphere (Fibonacci lattice)."""
    k = np.arange(count) + 0.5
    z = 1.0 - 2.0 * k / count
    turn = np.pi * (1.0 + np.sqrt(5.0)) * k
    flat = np.sqrt(1.0 - z**2)
    return np.column_stack([flat * np.cos(turn), flat * np.sin(turn), z])


def candidates(
    known: Held,
    library: Library,
    ball: Ball,
    rng: np.random.Generator,
    config: CandidateConfig | None = None,
) -> list[Approach]:
    """Approaches that begin outside a ball."""
    config = config or CandidateConfig()
    spin = se3.random_rotation(rng)
    found = []
    for way in directions(config.around) @ spin.T:
        found.append(toward(ball, ball.center, way, rng))
        for _ in range(config.aside):
            off = rng.normal(size=3) * config.off * ball.radius / np.sqrt(2.0)
            found.append(toward(ball, ball.center + off - way * float(off @ way), way, rng))
    if not len(known):
        return found
    share = known.weights / max(float(known.weights.sum()), 1e-12)
    for k in rng.choice(len(known), size=config.surfaces, p=share):
        points, normals = _surface(known, library, int(k))
        row = int(rng.integers(len(points)))
        found.append(toward(ball, points[row], -normals[row], rng))
    for a, b in _pairs(known, config.pairs):
        for mine, other in ((a, b), (b, a)):
            points, normals = _surface(known, library, mine)
            away = np.abs(known.solids[other].signed_distance(points))
            rows = np.flatnonzero(away > config.apart)
            if len(rows):
                few = rows[np.argsort(-away[rows])[:: max(1, len(rows) // config.differing)]]
                found += [toward(ball, points[r], -normals[r], rng) for r in few[: config.differing]]
                for place, face in _rims(points, normals, rows, config):
                    found.append(toward(ball, points[place], -normals[face], rng))
    return found


def toward(ball: Ball, place: Floats, direction: Floats, rng: np.random.Generator | None = None) -> Approach:
    """Through a (3,) place along a (3,) unit direction, from where that line enters the ball to its other side."""
    off = place - ball.center
    along = float(off @ direction)
    half = np.sqrt(max(ball.radius**2 - float(off @ off) + along**2, (0.3 * ball.radius) ** 2))
    hint = None if rng is None else rng.normal(size=3)
    attitude = se3.frame_along(direction, hint)
    return Approach(se3.pose(attitude, place - direction * (along + half)), 2.0 * float(half))


def _rims(points: Floats, normals: Floats, rows: Ints, config: CandidateConfig) -> list[tuple[int, int]]:
    """Of (n, 3) samples: those of some rows that lie nearest to a face beside theirs, and the sample there."""
    far = cdist(points[rows], points)
    far[normals[rows] @ normals.T > config.beside] = np.inf
    far[normals[rows] @ normals.T < -config.beside] = np.inf
    face = far.argmin(axis=1)
    order = np.argsort(far[np.arange(len(rows)), face])[: 3 * config.differing : 3]
    return [(int(rows[k]), int(face[k])) for k in order if np.isfinite(far[k, face[k]])]


def _surface(known: Held, library: Library, row: int) -> tuple[Floats, Floats]:
    """Samples of one hypothesis in the world."""
    samples, pose = library[known.names[row]].samples, known.solids[row].pose
    return se3.transform_points(pose, samples.points), se3.rotate(pose, samples.normals)


def _pairs(known: Held, most: int) -> list[tuple[int, int]]:
    """The best hypotheses of the likeliest names, and the best two of one name."""
    best = [rows[0] for rows in known.groups]
    best.sort(key=lambda row: -float(known.weights[[known.names[row] == n for n in known.names]].sum()))
    found = [(int(best[0]), int(b)) for b in best[1:most]]
    first = [int(r) for r in known.groups[0]]
    return [*found, *((first[0], r) for r in first[1 : 1 + max(0, most - len(found))])]
