"""Contacts to smooth patches, by growing shapes from neighborhoods.

A few seeds at a time: the shape of a seed's nearest contacts is grown by turns (take the connected contacts that
it explains, fit again) until it takes no more; the largest is a patch, and the rest goes on without it.  Patches
that one shape explains better than two are joined at the end (our derivation; compare CGAL's region growing,
which knows planes only).  "Near" is in (p, L n), L a few spacings, so that neighbors across an edge are far.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from primitives.arrays import Bools, Floats, Ints, frozen
from primitives.classify import rank
from primitives.evidence import Contacts, Patch
from primitives.fit import Fit, squares
from primitives.patch_graph import Face, MergeOptions, explains, join, ranked_face


@dataclass(frozen=True)
class SegmentOptions:
    """How patches grow."""

    seeds: int = 6  # neighborhoods tried for each patch
    neighborhood: int = 9  # contacts in one
    links: int = 8  # nearest contacts to which a patch may spread
    turns: int = 6  # most rounds of growing
    least: int = 5  # contacts in the smallest patch
    lift: float = 3.0  # spacings that a radian of the normal counts for
    kinds: tuple[str, ...] = ("plane", "sphere", "cylinder", "cone")  # grown; what is joined may be any
    outlier_chi2: tuple[float, float] = (10.83, 16.27)  # 99.9 % for a point alone, and with its normal
    merge: MergeOptions = field(default_factory=MergeOptions)


def segment(contacts: Contacts, options: SegmentOptions | None = None) -> tuple[Patch, ...]:
    """Patches, largest first; contacts that fit in none are in none."""
    options = options or SegmentOptions()
    if len(contacts) < options.least:
        return ()
    lifted = _lifted(contacts, options)
    links = _symmetric(_nearest(lifted, min(options.links + 1, len(contacts)))[1])
    free = np.ones(len(contacts), dtype=bool)
    found: list[Ints] = []
    while free.sum() >= options.least:
        seeds = _seeds(free, lifted, options)
        grown = [_grow(seed, free, contacts, lifted, links, options) for seed in seeds]
        largest = max(grown, key=len, default=np.empty(0, dtype=np.int64))
        if len(largest) < options.least:
            break
        found.append(largest)
        free[largest] = False
    joined = _joined(found, contacts, options)
    return tuple(
        Patch(contacts.select(rows), frozen(rows, np.int64)) for rows in sorted(joined, key=len, reverse=True)
    )


def _nearest(points: Floats, count: int) -> tuple[Floats, Ints]:
    """(n, count) distances and rows of each point's nearest, itself first."""
    distance, rows = cKDTree(points).query(points, k=count)
    return np.asarray(distance).reshape(-1, count), np.asarray(rows, dtype=np.int64).reshape(-1, count)


def _symmetric(near: Ints) -> csr_array:
    n, k = near.shape
    pairs = np.repeat(np.arange(n), k), near.ravel()
    graph = csr_array((np.ones(n * k), pairs), shape=(n, n))
    return csr_array(graph + graph.T)


def _lifted(contacts: Contacts, options: SegmentOptions) -> Floats:
    """(n, 6) points beside their normals in mm; points alone where a normal is missing."""
    if not contacts.has_normal.all():
        return contacts.points
    few = min(4, len(contacts) - 1)
    spacing = float(np.median(_nearest(contacts.points, few + 1)[0][:, few]))
    return np.concatenate([contacts.points, options.lift * spacing * contacts.normals], axis=1)


def _seeds(free: Bools, lifted: Floats, options: SegmentOptions) -> list[int]:
    """Free contacts whose free neighbors are nearest, none in the neighborhood of another."""
    rows = np.flatnonzero(free)
    count = min(options.neighborhood, len(rows))
    distance, near = _nearest(lifted[rows], count)
    chosen: list[int] = []
    covered = np.zeros(len(rows), dtype=bool)
    for i in np.argsort(distance.mean(axis=1)):
        if not covered[i] and len(chosen) < options.seeds:
            chosen.append(int(rows[i]))
            covered[near[i]] = True
    return chosen


def _grow(
    seed: int, free: Bools, contacts: Contacts, lifted: Floats, links: csr_array, options: SegmentOptions
) -> Ints:
    rows = np.flatnonzero(free)
    taken: Ints = rows[
        np.argsort(np.linalg.norm(lifted[rows] - lifted[seed], axis=1))[: options.neighborhood]
    ]
    grown: Ints = np.empty(0, dtype=np.int64)
    for _ in range(options.turns):
        ranked = rank(contacts.select(taken), options.kinds, options.merge.rank)
        if not ranked or not explains(ranked[0].fit, options.merge):
            if len(grown):
                break  # the last that was explained stands
            taken = taken[: len(taken) - 2]
            if len(taken) < options.least:
                break
            continue
        found = _explained(seed, ranked[0].fit, free, contacts, links, options)
        if len(found) < options.least or np.array_equal(found, grown):
            break
        grown = taken = found
    return grown


def _explained(
    seed: int, shape: Fit, free: Bools, contacts: Contacts, links: csr_array, options: SegmentOptions
) -> Ints:
    bound = np.where(contacts.has_normal, options.outlier_chi2[1], options.outlier_chi2[0])
    good = np.flatnonzero(free & (squares(shape, contacts) < options.merge.slack**2 * bound))
    if seed not in good:
        return np.empty(0, dtype=np.int64)
    _, label = connected_components(links[good][:, good], directed=False)
    return np.asarray(good[label == label[np.searchsorted(good, seed)]], dtype=np.int64)


def _joined(found: list[Ints], contacts: Contacts, options: SegmentOptions) -> list[Ints]:
    faces: list[tuple[Face, Ints]] = [
        (ranked_face(i, contacts.select(rows), options.merge), rows) for i, rows in enumerate(found)
    ]
    i = 0
    while i < len(faces):
        for j in range(i + 1, len(faces)):
            if join(faces[i][0], faces[j][0], options.merge):
                rows = np.concatenate([faces[i][1], faces[j][1]])
                faces[i] = (ranked_face(i, contacts.select(rows), options.merge), rows)
                del faces[j]
                break
        else:
            i += 1
    return [np.sort(rows) for _, rows in faces]
