"""Normals where none were felt: of the plane through a contact's neighbors, turned outward together.

The sense goes from contact to contact along the tree of neighbors whose planes agree most, from the outermost one,
which looks away from the rest (Hoppe et al. 1992).  How far off such a normal is, its neighbors tell: scattered by
a variance e^2 across the plane, and with a sum of squares S along its narrower direction, sigma = e / sqrt(S).
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree

from primitives.arrays import Bools, Floats, Ints
from primitives.evidence import Contacts
from primitives.segmentation.neighbors import nearest

_NEIGHBORS = 8
_LEAST, _MOST = 0.01, 0.5  # [rad] sigma of a normal that was not felt


def with_normals(contacts: Contacts) -> Contacts:
    """The same contacts, those without a normal with the one that their neighbors give."""
    felt = contacts.has_normal
    if felt.all():
        return contacts
    near = nearest(contacts.points, min(_NEIGHBORS + 1, len(contacts)))[1]
    normals, sigma = _planes(contacts, near)
    normals[felt] = contacts.normals[felt]
    normals = _turned(contacts.points, normals, near, felt)
    return Contacts.of(
        contacts.points,
        normals,
        contacts.sigma,
        np.where(felt, contacts.normal_sigma, sigma),
        contacts.touch,
        contacts.stroke,
        contacts.sensor,
        contacts.body,
    )


def _planes(contacts: Contacts, near: Ints) -> tuple[Floats, Floats]:
    """(n, 3) normals and their (n,) sigma [rad]."""
    groups = contacts.points[near]
    arms = groups - groups.mean(axis=1, keepdims=True)
    values, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", arms, arms))
    across = np.maximum(values[:, 0] / max(near.shape[1] - 3, 1), np.median(contacts.sigma) ** 2)
    sigma = np.sqrt(across / np.maximum(values[:, 1], 1e-12))
    return np.array(axes[:, :, 0]), np.clip(sigma, _LEAST, _MOST)


def _turned(points: Floats, normals: Floats, near: Ints, felt: Bools) -> Floats:
    """All to one side: felt ones stand, others follow their neighbors."""
    n, k = near.shape
    rows, columns = np.repeat(np.arange(n), k - 1), near[:, 1:].ravel()
    agree = np.abs((normals[rows] * normals[columns]).sum(axis=1))
    graph = csr_array((1.0 - agree + 1e-6, (rows, columns)), shape=(n, n))
    graph = csr_array(graph.maximum(graph.T))
    count, label = connected_components(graph, directed=False)
    tree = minimum_spanning_tree(graph)
    tree = csr_array(tree + tree.T)
    out = normals.copy()
    middle = points.mean(axis=0)
    for part in range(count):
        mine = np.flatnonzero(label == part)
        out_of = points[mine] - middle
        root = int(mine[np.argmax((out_of**2).sum(axis=1))])
        if out[root] @ (points[root] - middle) < 0 and not felt[root]:
            out[root] *= -1.0
        order, before = breadth_first_order(tree, root, directed=False)
        for i in order[1:]:
            if out[i] @ out[before[i]] < 0 and not felt[i]:
                out[i] *= -1.0
    return np.asarray(out)
