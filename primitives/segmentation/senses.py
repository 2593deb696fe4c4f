"""On which side of each face the material is, where no normal was felt: two laws that every closed surface obeys.

With s of {-1, 1} the sense of a face's normals, n a normal, p a contact and a the area that it stands for:

* neighbors  the normal at j, mirrored in the plane midway between i and j, agrees with that at i, across edges of
             either kind, and across thin walls and slots:  s_i s_j n_i . (n_j - 2 (e . n_j) e) > 0,  e from i to j
             (after Koenig and Gumhold 2009, "Consistent propagation of normal orientations in point clouds")
* all        a closed surface is seen under half of all directions from each of its points (Gauss):
             sum over j of  a_j s_j n_j . (p_j - p_i) / (4 pi |p_j - p_i|^3) = 1 / 2

Both count per contact (our derivation); the first has no sense of its own, the second has.  The second, solved as
linear, is where to begin; then single faces turn, and all at once, until none pays.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from primitives.arrays import Floats, Ints
from primitives.segmentation.neighbors import nearest

_AREA = 6  # neighbors on a face that tell how much of it a contact stands for
_GAUSS = 8.0  # weight of the second law beside one neighbor of the first


def senses(points: Floats, normals: Floats, face: Ints, known: Floats, links: csr_array) -> Floats:
    """(f,) 1 or -1 by which (n, 3) normals of a face look out; `known` (f,) is that where felt, else 0.

    `face` (n,) is that of each contact, -1 for none, which then is left out.
    """
    count = len(known)
    held = np.flatnonzero(face >= 0)
    if not len(held) or (known != 0).all():
        return known
    mine = face[held]
    seen = _seen(points[held], normals[held], mine, count)
    votes = _votes(points, normals, face, links, count)
    free = known == 0
    target = 0.5 - seen @ known
    start = np.linalg.lstsq(seen[:, free], target, rcond=1e-3)[0]
    sense = known.astype(float).copy()
    sense[free] = np.where(start < 0, -1.0, 1.0)
    return _settled(sense, free, votes, seen)


def _settled(sense: Floats, free: Floats, votes: Floats, seen: Floats) -> Floats:
    """Single turns, or one of all free faces, until none lowers the energy."""

    def energy(s: Floats) -> float:
        return float(-0.5 * s @ votes @ s + _GAUSS * ((seen @ s - 0.5) ** 2).sum())

    single = [np.eye(len(sense), dtype=bool)[k] for k in np.flatnonzero(free)]
    moves = [*single, free]
    least = energy(sense)
    for _ in range(4 * len(moves)):
        turned = [np.where(move, -sense, sense) for move in moves]
        costs = [energy(s) for s in turned]
        best = int(np.argmin(costs))
        if costs[best] >= least - 1e-9:
            break
        sense, least = turned[best], costs[best]
    return sense


def _votes(points: Floats, normals: Floats, face: Ints, links: csr_array, count: int) -> Floats:
    """(f, f) how many neighbors on two faces want their senses equal, less those that want them opposed."""
    i, j = links.nonzero()
    across = (face[i] != face[j]) & (face[i] >= 0) & (face[j] >= 0)
    i, j = i[across], j[across]
    arm = points[j] - points[i]
    arm /= np.maximum(np.linalg.norm(arm, axis=1, keepdims=True), 1e-12)
    mirrored = normals[j] - 2.0 * (arm * normals[j]).sum(axis=1, keepdims=True) * arm
    agree = (normals[i] * mirrored).sum(axis=1)
    out = np.zeros((count, count))
    np.add.at(out, (face[i], face[j]), agree)
    return out


def _seen(points: Floats, normals: Floats, face: Ints, count: int) -> Floats:
    """(n, f) share of all directions under which each contact sees each face from behind."""
    area = np.zeros(len(points))
    for k in range(count):
        rows = np.flatnonzero(face == k)
        if len(rows) > 1:
            m = min(_AREA, len(rows) - 1)
            reach = nearest(points[rows], m + 1)[0][:, m]
            area[rows] = np.pi * np.median(reach) ** 2 / m
    out = np.zeros((len(points), count))
    for k in range(count):
        rows = np.flatnonzero(face == k)
        arms = points[rows] - points[:, None]
        square = np.maximum((arms**2).sum(axis=2) + area[rows] / np.pi, 1e-12)
        out[:, k] = ((arms * normals[rows]).sum(axis=2) * area[rows] / square**1.5).sum(axis=1) / (4 * np.pi)
    return out
