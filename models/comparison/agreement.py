"""Whether a rigid motion carries one boundary's faces, edges and corners onto another's, and how nearly.

With the center of `a` moved onto that of `b`, a point p of `a` comes to lie at ``rotation p + shift``.
"""

from __future__ import annotations

import numpy as np

from models.comparison.likeness import SameConfig, play
from models.comparison.outline import Outline
from primitives.arrays import Bools, Floats, Ints


def faces_carried(
    a: Outline,
    b: Outline,
    round_edges: dict[frozenset[int], list[int]],
    edges: Ints,
    bare: Ints,
    rotation: Floats,
    shift: Floats,
    config: SameConfig,
) -> Ints | None:
    """(f,) face of b for each of a: the one round which its edges come to lie, if the surfaces agree."""
    out = np.full(a.graph.faces, -1)
    out[a.bare] = b.bare[bare]
    rims = [[edges[e] for loop in face.loops for e in loop] for face in a.brep.faces]
    doubtful: list[tuple[int, list[int]]] = []
    for f, rim in enumerate(rims):
        if not rim:
            continue
        like = round_edges.get(frozenset(rim))
        if not like:
            return None
        if len(like) == 1:
            out[f] = like[0]
        else:
            doubtful.append((f, like))
    for f, like in doubtful:
        fits = [g for g in like if _alike(a, b, np.array([f]), np.array([g]), rotation, shift, config)[0]]
        free = [g for g in fits if g not in out]
        if not free:
            return None
        out[f] = free[0]
    if len(np.unique(out)) != len(out):
        return None
    return out if bool(_alike(a, b, np.arange(len(out)), out, rotation, shift, config).all()) else None


def _alike(
    a: Outline, b: Outline, mine: Ints, theirs: Ints, rotation: Floats, shift: Floats, config: SameConfig
) -> Bools:
    """(n,) whether the surfaces of faces agree: kind, side, sizes, area, direction and place."""
    slack = config.tolerance * np.maximum(a.slack[mine], b.slack[theirs])
    same = a.kind[mine] == b.kind[theirs]
    same &= (np.abs(a.sizes[mine] - b.sizes[theirs]) <= slack[:, None]).all(axis=1)
    cosine = np.einsum("ij,ij->i", a.direction[mine] @ rotation.T, b.direction[theirs])
    turned = np.where(a.signed[mine], cosine, np.abs(cosine)) < 0.95
    same &= ~(turned & a.direction[mine].any(axis=1))
    off = a.anchor[mine] @ rotation.T + shift - b.anchor[theirs]
    same &= (np.linalg.norm(off, axis=1) <= 2 * slack) | ~_of_kind(a, mine, ("sphere", "torus"))
    along = np.einsum("ij,ij->i", off, b.direction[theirs])
    same &= (np.abs(along) <= 2 * slack) | ~_of_kind(a, mine, ("plane",))
    aside = np.linalg.norm(off - along[:, None] * b.direction[theirs], axis=1)
    same &= (aside <= 2 * slack) | ~_of_kind(a, mine, ("cylinder",))
    faces, others = [a.brep.faces[f] for f in mine], [b.brep.faces[f] for f in theirs]
    area, other = (np.array([face.area for face in some]) for some in (faces, others))
    loose = a.length * play(a, config.tolerance)[0]
    rim = np.array([sum(loose[e] for loop in face.loops for e in loop) for face in faces])
    same &= np.abs(area - other) <= config.area * np.maximum(area, other) + rim
    return np.asarray(same & np.array([p.convex == q.convex for p, q in zip(faces, others, strict=True)]))


def _of_kind(whole: Outline, faces: Ints, kinds: tuple[str, ...]) -> Bools:
    return np.array([whole.brep.faces[f].kind in kinds for f in faces], dtype=bool)


def edges_agree(a: Outline, b: Outline, edges: Ints, faces: Ints) -> bool:
    """Whether each edge comes to lie between the faces that its own two are carried onto."""
    if not len(edges):
        return True
    mine = np.sort(faces[[edge.faces for edge in a.brep.edges]], axis=1)
    theirs = np.sort(np.array([edge.faces for edge in b.brep.edges])[edges], axis=1)
    return bool(np.array_equal(mine, theirs))


def corner_errors(a: Outline, b: Outline, corners: Ints, rotation: Floats, shift: Floats) -> Floats:
    """(v,) [mm] between corners."""
    return np.asarray(np.linalg.norm(a.vertices @ rotation.T + shift - b.vertices[corners], axis=1))


def edge_errors(
    a: Outline, b: Outline, edges: Ints, rotation: Floats, shift: Floats, enough: Floats
) -> Floats:
    """(e,) [mm] between edges: sample to sample, circle to circle; if that is not `enough`, curve to curve."""
    goal = b.samples[edges]
    moved = a.samples @ rotation.T + shift
    forth = np.linalg.norm(moved - goal, axis=2).max(axis=1, initial=0.0)
    back = np.linalg.norm(moved - goal[:, ::-1], axis=2).max(axis=1, initial=0.0)
    worst = np.minimum(forth, back)
    spun, other = a.spin @ rotation.T, b.spin[edges]
    apart = np.linalg.norm(a.middle @ rotation.T + shift - b.middle[edges], axis=1)
    tilted = np.minimum(np.linalg.norm(spun - other, axis=1), np.linalg.norm(spun + other, axis=1))
    round_ = a.circle & b.circle[edges]
    worst[round_] = (apart + tilted)[round_]
    for i in np.flatnonzero(worst > enough):
        worst[i] = min(worst[i], _curve_error(a, b, int(i), int(edges[i]), rotation, shift))
    return np.asarray(worst)


def _curve_error(a: Outline, b: Outline, i: int, j: int, rotation: Floats, shift: Floats) -> float:
    """[mm] Hausdorff distance between two curves, from the points of each to the chords of the other."""
    mine = (a.brep.edges[i].points - a.center) @ rotation.T + shift
    theirs = b.brep.edges[j].points - b.center
    return max(_farthest(mine, theirs), _farthest(theirs, mine))


def _farthest(points: Floats, line: Floats) -> float:
    start, step = line[:-1], np.diff(line, axis=0)
    share = np.einsum("nki,ki->nk", points[:, None] - start, step) / np.maximum((step**2).sum(axis=1), 1e-300)
    nearest = start + np.clip(share, 0, 1)[:, :, None] * step
    return float(np.linalg.norm(points[:, None] - nearest, axis=2).min(axis=1).max())
