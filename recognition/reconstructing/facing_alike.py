"""A table's normals turned alike within each face, where some point out of the object and others into it.

Two contacts i and j lie on one smooth face, their normals with a sense s of {-1, 1} to each other, where with e
from one to the other

    e . (n_i + s n_j) / 2 = 0

but for noise: it is so on planes and spheres, and is its thickness where they lie on both sides of a wall (our
derivation).  Along the tree of neighbors whose normals agree most each contact's sense to all others of its face
follows, and those of the lesser number are turned.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, minimum_spanning_tree
from scipy.spatial import cKDTree

from primitives.arrays import Bools, Floats, Ints, frozen
from recognition.sources import Source


@dataclass(frozen=True)
class FacingOptions:
    """When neighbors are of one face, and when they are asked."""

    neighbors: int = 8
    fewest: int = 30  # contacts, below which neighbors are seldom of one face
    sounded: int = 2000  # contacts that tell whether any must be turned
    agree: float = 0.9  # cosine between the normals of two neighbors on one face
    wide: float = 3.0  # times the usual noise, within which they are
    rare: float = 0.01  # share of such neighbors that look opposite ways, up to which nothing is done


def facing_alike(source: Source, options: FacingOptions | None = None) -> Source:
    """The source, the normals of contacts that came without a run turned as most are on their face."""
    options = options or FacingOptions()
    felt = np.flatnonzero(source.contacts.has_normal)
    if source.kind != "contacts" or len(felt) < options.fewest:
        return source
    points, normals = source.contacts.points[felt], source.contacts.normals[felt]
    some = np.random.default_rng(0).permutation(len(felt))[: options.sounded]
    cosine = _pairs(points, normals, some, options)[1]
    if (cosine < 0).sum() <= options.rare * len(cosine):
        return source
    every = np.arange(len(felt))
    turned = np.zeros(len(source.contacts), dtype=bool)
    turned[felt] = _lesser(normals, *_pairs(points, normals, every, options))
    table = np.where(turned[:, None], -source.contacts.normals, source.contacts.normals)
    share = turned.sum() / len(felt)
    told = (
        f"the normals of {share:.0%} of the contacts point against those beside them, and were turned round; turn "
        "them in the file"
    )
    contacts = replace(source.contacts, normals=frozen(table))
    return replace(source, contacts=contacts, warnings=(*source.warnings, told))


def _pairs(points: Floats, normals: Floats, rows: Ints, options: FacingOptions) -> tuple[Ints, Floats]:
    """(2, m) rows of neighbors on one face, one of each pair in `rows`; (m,) the cosine between their normals."""
    near = np.asarray(cKDTree(points).query(points[rows], k=options.neighbors + 1)[1])
    i, j = np.repeat(rows, options.neighbors), near[:, 1:].ravel()
    cosine = np.einsum("ij,ij->i", normals[i], normals[j])
    apart = points[j] - points[i]
    off = np.abs(np.einsum("ij,ij->i", apart, normals[i] + np.sign(cosine)[:, None] * normals[j])) / 2.0
    alike = np.abs(cosine) > options.agree
    if not alike.any():
        return np.empty((2, 0), dtype=np.int64), np.empty(0)
    least = 1e-4 * float(np.median(np.linalg.norm(apart, axis=1)))
    same = alike & (off <= options.wide * np.median(off[alike & (cosine > 0)]) + least)
    return np.stack([i, j])[:, same], cosine[same]


def _lesser(normals: Floats, pairs: Ints, cosine: Floats) -> Bools:
    """(n,) whether a contact looks the other way than most of its face."""
    n = len(normals)
    tree = minimum_spanning_tree(csr_array((1.0 - np.abs(cosine) + 1e-6, tuple(pairs)), shape=(n, n)))
    i, j = tree.nonzero()
    against = np.einsum("ij,ij->i", normals[i], normals[j]) < 0
    # every contact stands for itself and, n further on, for its opposite: what hangs together looks alike
    rows, columns = np.concatenate([i, i + n]), np.concatenate([j + n * against, j + n * ~against])
    graph = csr_array((np.ones(len(rows)), (rows, columns)), shape=(2 * n, 2 * n))
    label = connected_components(graph, directed=False)[1]
    face = np.minimum(label[:n], label[n:])
    sense = np.where(label[:n] == face, 1.0, -1.0)
    most = np.bincount(face, sense)
    return np.asarray(sense * most[face] < 0)
