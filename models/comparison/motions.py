"""The rigid motions that carry one boundary onto another.

Each guess at the rotation is settled by least squares over all corners and edges, matched to the nearest of
their color, and then held to every face, edge and corner.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from models.comparison.agreement import corner_errors, edge_errors, edges_agree, faces_carried
from models.comparison.guesses import guesses
from models.comparison.incidence import Colors
from models.comparison.likeness import SameConfig, play
from models.comparison.outline import Outline
from primitives.arrays import Floats, Ints, frozen
from primitives.pose import pose, rotation_exp


@dataclass(frozen=True, eq=False)
class Carried:
    """A rigid motion, and what it carries onto what."""

    b_from_a: Floats  # (4, 4)
    faces: Ints  # (f,) face of b for each of a
    edges: Ints  # (e,)
    vertices: Ints  # (v,)
    residual: float  # [mm] the worst of corners and edges


def motions(a: Outline, b: Outline, colors: tuple[Colors, Colors], config: SameConfig) -> Iterator[Carried]:
    """Every rotation that carries a onto b, once for each trial that finds it."""
    target = _Target(b, colors[1])
    for rotation in guesses(a, b, colors, config.tolerance):
        if found := _settled(a, target, colors[0], rotation, config):
            yield found


class _Target:
    """The second boundary, made ready for many trials."""

    def __init__(self, whole: Outline, colors: Colors) -> None:
        self.whole = whole
        self.colors = np.unique(colors)
        self.scale = 1e3 * max(whole.size, 1.0)
        points, keys = nodes(whole, colors)
        self.count = len(points)
        self.tree = cKDTree(self.lifted(points, keys))
        self.points = points
        self.face_of: dict[frozenset[int], list[int]] = {}
        for f, face in enumerate(whole.brep.faces):
            if face.loops:
                self.face_of.setdefault(frozenset(e for loop in face.loops for e in loop), []).append(f)

    def nearest(self, points: Floats, keys: Colors) -> tuple[Floats, Ints]:
        """(n,) distance [mm] and index of the nearest point of the same color."""
        away, found = self.tree.query(self.lifted(points, keys))
        return np.atleast_1d(away), np.atleast_1d(found)

    def lifted(self, points: Floats, keys: Colors) -> Floats:
        """(n, 4) points with their colors held so far apart that only equal ones are neighbors."""
        rank = np.searchsorted(self.colors, keys)
        return np.column_stack([points, rank * self.scale])


def nodes(whole: Outline, colors: Colors) -> tuple[Floats, Colors]:
    """The points that answer to each other one to one: corners, edges' centroids, faces without edges."""
    f, e = whole.graph.faces, whole.graph.edges
    keys = np.concatenate(
        [colors[f + e : f + e + whole.graph.vertices], colors[f : f + e], colors[whole.bare]]
    )
    return np.concatenate([whole.vertices, whole.middle, whole.anchor[whole.bare]]), keys


def _settled(
    a: Outline, target: _Target, colors: Colors, rotation: Floats, config: SameConfig
) -> Carried | None:
    """The motion near a guessed rotation that carries all of a onto b, if there is one."""
    points, keys = nodes(a, colors)
    b, shift = target.whole, np.zeros(3)
    far = config.gate * a.size + 4 * config.tolerance
    loose, loose_corners = play(a, config.tolerance)
    allowed = np.concatenate([loose_corners, loose])
    trust = np.append(config.tolerance / allowed, np.ones(len(a.bare)))
    answer = np.empty(0, dtype=np.int64)
    for _ in range(3):
        away, found = target.nearest(points @ rotation.T + shift, keys)
        if len(points) != target.count or float(away.max(initial=0.0)) > far:
            return None
        if np.array_equal(found, answer):
            break
        answer = found
        rotation, shift = _least_squares(points, target.points[answer], trust, rotation, shift, a.size)
    if len(np.unique(answer)) != len(points):
        return None
    v, e = a.graph.vertices, a.graph.edges
    corners, edges, bare = answer[:v], answer[v : v + e] - v, answer[v + e :] - v - e
    faces = faces_carried(a, b, target.face_of, edges, bare, rotation, shift, config)
    if faces is None or not edges_agree(a, b, edges, faces):
        return None
    errors = np.concatenate(
        [
            corner_errors(a, b, corners, rotation, shift),
            edge_errors(a, b, edges, rotation, shift, allowed[v:]),
        ]
    )
    if (errors > allowed).any():
        return None
    b_from_a = pose(rotation, b.center + shift - rotation @ a.center)
    return Carried(frozen(b_from_a), faces, edges, corners, float(errors.max(initial=0.0)))


def _least_squares(
    points: Floats, goals: Floats, trust: Floats, rotation: Floats, shift: Floats, scale: float
) -> tuple[Floats, Floats]:
    """One Gauss-Newton step toward goals = rotation points + shift; turns that move none are left alone."""
    if not len(points):
        return rotation, shift
    moved = points @ rotation.T
    x, y, z = moved.T
    zero = np.zeros_like(x)
    turn = np.stack([zero, z, -y, -z, zero, x, y, -x, zero], axis=1).reshape(-1, 3, 3)
    system = np.concatenate([turn / scale, np.broadcast_to(np.eye(3), (len(x), 3, 3))], axis=2)
    rows, left = system * trust[:, None, None], (goals - moved - shift) * trust[:, None]
    step = np.linalg.lstsq(rows.reshape(-1, 6), left.ravel(), rcond=1e-6)[0]
    return rotation_exp(step[:3] / scale) @ rotation, shift + step[3:]
