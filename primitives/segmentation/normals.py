"""Normals where none were felt: those of the likeliest local pieces, turned alike from neighbor to neighbor.

The sense goes along the tree of neighbors whose planes agree most (Hoppe et al. 1992), so that it is one within a
smooth face; on which side the material is, `senses` tells once the faces are known.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree

from primitives.arrays import Bools, Floats, frozen
from primitives.evidence import Contacts
from primitives.segmentation.local_fits import local_normals
from primitives.segmentation.neighbors import nearest

_NEIGHBORS = 8
_LEAST, _MOST = 0.02, 1.0  # [rad] sigma of a normal that was not felt


def with_normals(contacts: Contacts, among: Floats | None = None) -> Contacts:
    """The same contacts, those without a normal with the one that their neighbors give.

    `among` (m, 3) are the points that neighbors are taken from, these contacts' first; None for these alone.
    """
    felt = contacts.has_normal
    if felt.all():
        return contacts
    bare = np.flatnonzero(~felt)
    points = contacts.points if among is None else among
    found, spread = local_normals(points, bare, float(np.median(contacts.sigma)))
    normals, sigma = np.array(contacts.normals), np.array(contacts.normal_sigma)
    normals[bare], sigma[bare] = found, np.clip(spread, _LEAST, _MOST)
    normals = _alike(contacts.points, normals, felt)
    return replace(contacts, normals=frozen(normals), normal_sigma=frozen(sigma))


def _alike(points: Floats, normals: Floats, felt: Bools) -> Floats:
    """Felt ones stand, others follow their neighbors."""
    near = nearest(points, min(_NEIGHBORS + 1, len(points)))[1]
    n, k = near.shape
    rows, columns = np.repeat(np.arange(n), k - 1), near[:, 1:].ravel()
    agree = np.abs((normals[rows] * normals[columns]).sum(axis=1))
    graph = csr_array((1.0 - agree + 1e-6, (rows, columns)), shape=(n, n))
    graph = csr_array(graph.maximum(graph.T))
    count, label = connected_components(graph, directed=False)
    tree = minimum_spanning_tree(graph)
    tree = csr_array(tree + tree.T)
    out = normals.copy()
    for part in range(count):
        mine = np.flatnonzero(label == part)
        root = int(mine[np.argmax(felt[mine])])
        order, before = breadth_first_order(tree, root, directed=False)
        for i in order[1:]:
            if out[i] @ out[before[i]] < 0 and not felt[i]:
                out[i] *= -1.0
    return np.asarray(out)
