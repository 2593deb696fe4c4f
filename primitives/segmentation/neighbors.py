"""Which contacts are neighbors on the surface: nearest in (p, L n), L a few spacings, so that edges part them."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from primitives.arrays import Bools, Floats, Ints

_SPACING = 4  # the neighbor whose distance is a spacing
_LIFT = 1.5  # spacings that a radian of the normal counts for


def lifted(points: Floats, normals: Floats) -> Floats:
    """(n, 6) points beside their normals in mm."""
    few = min(_SPACING, len(points) - 1)
    spacing = float(np.median(nearest(points, few + 1)[0][:, few]))
    return np.concatenate([points, _LIFT * spacing * normals], axis=1)


def nearest(points: Floats, count: int) -> tuple[Floats, Ints]:
    """(n, count) distances and rows of each point's nearest, itself first."""
    distance, rows = cKDTree(points).query(points, k=count)
    return np.asarray(distance).reshape(-1, count), np.asarray(rows, dtype=np.int64).reshape(-1, count)


def linked(near: Ints) -> csr_array:
    """(n, n) 1 where either is among the other's nearest."""
    n, k = near.shape
    graph = csr_array((np.ones(n * k), (np.repeat(np.arange(n), k), near.ravel())), shape=(n, n))
    graph = csr_array(graph + graph.T)
    graph.setdiag(0)
    graph.eliminate_zeros()
    graph.data[:] = 1.0
    return graph


def heaviest_part(rows: Bools, worth: Floats, links: csr_array) -> Ints:
    """Of the rows of a mask, the connected ones that are worth most together."""
    chosen = np.flatnonzero(rows)
    if not len(chosen):
        return chosen
    count, label = connected_components(links[chosen][:, chosen], directed=False)
    if count == 1:
        return chosen
    return np.asarray(chosen[label == np.bincount(label, worth[chosen]).argmax()])
