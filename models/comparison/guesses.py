"""Rotations worth trying: a pair of one boundary's vectors laid on every pair of the other that looks the same.

Vectors that turn with the part run from its center to a corner or along an axis.  The pair is chosen for few
look-alikes and for length, so the number of guesses is at most the product of two color counts: for a part
with n-fold symmetry, about 2 n.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from models.comparison.incidence import Colors, mixed
from models.comparison.outline import Outline
from primitives.arrays import Bools, Floats
from primitives.pose import frame_along, rotation_exp

_AXIS, _EITHER, _SPIN, _BEND = 1, 2, 3, 4  # what a vector is, beside the offset of a point


def guesses(a: Outline, b: Outline, colors: tuple[Colors, Colors], t: float) -> Iterator[Floats]:
    """(3, 3) rotations that carry a pair of a's vectors onto a pair of b's that looks the same."""
    mine, keys, reach = _vectors(a, colors[0])
    theirs, their_keys, _ = _vectors(b, colors[1])
    long = reach > max(4 * t, 1e-3 * a.size)
    if not long.any():
        yield np.eye(3)
        return
    count = np.searchsorted(np.sort(keys), keys, "right") - np.searchsorted(np.sort(keys), keys, "left")
    cost = count * (1 + (0.3 * a.size / np.maximum(reach, 1e-9 * a.size)) ** 2)
    i = int(np.argmin(np.where(long, cost, np.inf)))
    slope = mine @ mine[i]
    across = np.sqrt(np.maximum(1 - slope**2, 0))
    cost = np.where(long & (across > 0.1), cost / np.maximum(across, 0.1) ** 2, np.inf)
    firsts = np.flatnonzero(their_keys == keys[i])
    if not np.isfinite(cost).any():
        for k in firsts:
            yield _turned(mine[i], theirs[k])
        return
    j = int(np.argmin(cost))
    blur = 4 * t * (1 / reach[i] + 1 / reach[j]) + 1e-6
    before = frame_along(mine[i], mine[j])
    seconds = np.flatnonzero(their_keys == keys[j])
    for k in firsts:
        near = np.abs(theirs[seconds] @ theirs[k] - slope[j]) < blur
        for m in seconds[near]:
            if np.linalg.norm(np.cross(theirs[k], theirs[m])) > 0.05:
                yield frame_along(theirs[k], theirs[m]) @ before.T


def _vectors(whole: Outline, colors: Colors) -> tuple[Floats, Colors, Floats]:
    """(m, 3) vectors that turn with the part, as long as the part; what each is; how far it reaches [mm]."""
    f, e = whole.graph.faces, whole.graph.edges
    edge_colors, vertex_colors = colors[f : f + e], colors[f + e : f + e + whole.graph.vertices]
    points = np.concatenate([whole.vertices, whole.middle, whole.anchor[whole.bare]])
    keys = [np.concatenate([vertex_colors, edge_colors, colors[whole.bare]])]
    far = np.linalg.norm(points, axis=1)
    vectors, reach = [points / np.maximum(far, 1e-300)[:, None]], [far]
    wide = np.sqrt([face.area for face in whole.brep.faces])
    bends, bent, bend_reach = _bends(whole)
    for some, directions, color, role, length in (
        (whole.signed, whole.direction, colors[:f], _AXIS, wide),
        (~whole.signed & whole.direction.any(axis=1), whole.direction, colors[:f], _EITHER, wide),
        (whole.circle, _unit(whole.spin), edge_colors, _SPIN, np.linalg.norm(whole.spin, axis=1)),
        (bent, bends, edge_colors, _BEND, bend_reach),
    ):
        for sign in (1.0,) if role == _AXIS else (1.0, -1.0):
            vectors.append(sign * directions[some])
            keys.append(mixed(color[some] + np.uint64(role)))
            reach.append(np.minimum(length[some], whole.size))
    return np.concatenate(vectors), np.concatenate(keys), np.concatenate(reach)


def _bends(whole: Outline) -> tuple[Floats, Bools, Floats]:
    """(e, 3) the direction in which each rim that is no circle lies farthest from round, if one stands out."""
    if not len(whole.middle):
        return np.empty((0, 3)), np.zeros(0, dtype=bool), np.zeros(0)
    spread = whole.samples[:, :-1] - whole.samples[:, :-1].mean(axis=1, keepdims=True)
    size, axes = np.linalg.eigh(np.einsum("eki,ekj->eij", spread, spread) / (spread.shape[1]))
    rim = np.array([edge.vertices is None for edge in whole.brep.edges]) & ~whole.circle
    return axes[:, :, 0], rim & (size[:, 1] > 2 * size[:, 0] + 1e-6), np.sqrt(np.maximum(size[:, 1], 0.0))


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-300))


def _turned(a: Floats, b: Floats) -> Floats:
    """The least rotation that takes unit a to unit b."""
    axis, cosine = np.cross(a, b), float(a @ b)
    sine = float(np.linalg.norm(axis))
    if sine < 1e-9:
        side = frame_along(a)[:, 0]
        return np.eye(3) if cosine > 0 else rotation_exp(np.pi * side)
    return rotation_exp(axis / sine * np.arctan2(sine, cosine))
