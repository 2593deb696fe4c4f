"""Any cloud of contacts -> the faces that it lies on, from ten contacts to a million.

Growing shapes takes more than linear time, so it is done on a bounded choice of the contacts; all others then join
the face that explains them best, and what no face explains is looked at again, until nothing new is found.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from primitives.arrays import Ints
from primitives.evidence import Contacts
from primitives.fit import Fit, squares
from primitives.patch_graph import Face, MergeOptions, PatchGraph, ranked_face
from primitives.segment import segment


@dataclass(frozen=True)
class SurfaceOptions:
    """How much is looked at."""

    chosen: int = 1500  # contacts among which shapes are grown
    fitted: int = 1500  # contacts of a face to which it is fitted
    rounds: int = 3  # times that unexplained contacts are looked at again
    least: float = 0.002  # of all contacts: fewer that are left unexplained are strays
    outlier_chi2: tuple[float, float] = (10.83, 16.27)  # 99.9 % for a point alone, and with its normal


def surfaces(contacts: Contacts, options: SurfaceOptions | None = None) -> PatchGraph:
    """The faces, and what lies on none left out."""
    options, merging = options or SurfaceOptions(), MergeOptions()
    order = np.random.default_rng(0).permutation(len(contacts))
    free = np.ones(len(contacts), dtype=bool)
    faces: list[Face] = []
    for _ in range(1 + options.rounds):
        rest = order[free[order]]
        if len(rest) < max(5, options.least * len(contacts)):
            break
        picked = contacts.select(np.sort(rest[: options.chosen]))
        found = [ranked_face(0, patch.contacts, merging) for patch in segment(picked)]
        if not any(isinstance(face.fit, Fit) for face in found):
            break
        faces += [face for face in found if isinstance(face.fit, Fit)]
        if len(contacts) <= options.chosen:
            return PatchGraph(tuple(_numbered(i, face) for i, face in enumerate(faces)))
        free = _owners(contacts, faces, options) < 0
    owner = _owners(contacts, faces, options)
    out: list[Face] = []
    for i in range(len(faces)):
        mine = order[owner[order] == i]
        if len(mine) < 5:
            continue
        again = ranked_face(len(out), contacts.select(np.sort(mine[: options.fitted])), merging)
        out.append(Face(again.id, again.fit, contacts.select(np.sort(mine)), again.ranked))
    return PatchGraph(tuple(out))


def _owners(contacts: Contacts, faces: list[Face], options: SurfaceOptions) -> Ints:
    """(n,) the face that explains each contact best; -1 where none does."""
    if not faces:
        return np.full(len(contacts), -1, dtype=np.int64)
    slack = MergeOptions().slack ** 2
    bound = slack * np.where(contacts.has_normal, options.outlier_chi2[1], options.outlier_chi2[0])
    costs = np.stack([squares(face.fit, contacts) for face in faces if isinstance(face.fit, Fit)])
    best = costs.argmin(axis=0)
    return np.where(costs.min(axis=0) < bound, best, -1).astype(np.int64)


def _numbered(number: int, face: Face) -> Face:
    return Face(number, face.fit, face.contacts, face.ranked)
