"""A bounding-volume tree over triangles: nearest points with their sign, and first hits of rays.

The sign of the distance comes from the angle-weighted pseudonormal of the nearest feature, which is right
for every closed mesh (Baerentzen and Aanaes 2005).  Triangles are sorted along Morton's curve and halved level
by level, without a loop over triangles; the kernels are compiled on first use and cached.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from models.boundaries.topology import edge_keys
from models.rays.triangle_kernels import first_hits_in_tree, nearest_in_tree
from primitives.arrays import Floats, Ints

_LEAF = 4  # triangles a leaf holds at most
_SPREAD = [  # doubles the gaps between bits until two empty ones follow each
    (np.uint64(32), np.uint64(0x1F00000000FFFF)),
    (np.uint64(16), np.uint64(0x1F0000FF0000FF)),
    (np.uint64(8), np.uint64(0x100F00F00F00F00F)),
    (np.uint64(4), np.uint64(0x10C30C30C30C30C3)),
    (np.uint64(2), np.uint64(0x1249249249249249)),
]


class Nearest(NamedTuple):
    """The nearest point of a mesh to each of n points."""

    distance: Floats  # (n,) [mm] not negative
    triangle: Ints  # (n,)
    points: Floats  # (n, 3) [mm]
    feature: Ints  # (n,) of the triangle: 0 inside, 1 to 3 the edge from corner i - 1, 4 to 6 corner i - 4


class TriangleTree:
    """A tree over (v, 3) vertices [mm] and (t, 3) triangles."""

    def __init__(self, vertices: Floats, triangles: Ints) -> None:
        self._corners = np.ascontiguousarray(vertices[triangles], dtype=np.float64)
        self._triangles = triangles
        self._vertices = vertices
        low, high = self._corners.min(axis=1), self._corners.max(axis=1)
        self._boxes, self._nodes, self._order = _build(low, high)

    @property
    def arrays(self) -> tuple[Floats, Ints, Ints]:
        """Boxes, nodes and the triangles' order, as `models.rays.triangle_kernels` reads them."""
        return self._boxes, self._nodes, self._order

    def nearest(self, points: Floats) -> Nearest:
        """The nearest point of the mesh to each of (n, 3) points [mm]."""
        wanted = np.ascontiguousarray(points, dtype=np.float64)
        return Nearest(*nearest_in_tree(wanted, self._corners, self._boxes, self._nodes, self._order))

    def signed_distance(self, points: Floats) -> Floats:
        """(n,) distance of (n, 3) points [mm], negative inside a closed mesh."""
        found = self.nearest(points)
        towards = np.einsum("ij,ij->i", points - found.points, self._pseudonormals_at(found))
        return np.where(towards < 0, -found.distance, found.distance)

    def first_hits(
        self, origins: NDArray[np.float32], directions: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        """Distance (n,) and triangle (n,), or inf and -1, of (n, 3) rays."""
        distance, triangle = first_hits_in_tree(
            origins, directions, self._corners, self._boxes, self._nodes, self._order
        )
        return distance, triangle

    def _pseudonormals_at(self, found: Nearest) -> Floats:
        table, feature = self._pseudonormals, found.feature
        return table[found.triangle, feature]

    @cached_property
    def _pseudonormals(self) -> Floats:
        corners, triangles = self._corners, self._triangles
        edges = np.roll(corners, -1, axis=1) - corners
        normals = np.cross(edges[:, 0], edges[:, 1])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
        units = edges / np.maximum(np.linalg.norm(edges, axis=2, keepdims=True), 1e-300)
        angles = np.arccos(np.clip(-np.einsum("tij,tij->ti", units, np.roll(units, 1, axis=1)), -1, 1))
        at_vertex = np.zeros((len(self._vertices), 3))
        for corner in range(3):
            np.add.at(at_vertex, triangles[:, corner], angles[:, corner, None] * normals)
        edge_of = np.unique(edge_keys(triangles), return_inverse=True)[1].reshape(-1)
        at_edge = np.zeros((edge_of.max(initial=-1) + 1, 3))
        np.add.at(at_edge, edge_of, np.repeat(normals, 3, axis=0))
        by_edge = at_edge[edge_of].reshape(-1, 3, 3)
        return np.concatenate([normals[:, None], by_edge, at_vertex[triangles]], axis=1)


def _build(low: Floats, high: Floats) -> tuple[Floats, Ints, Ints]:
    """Boxes (m, 6), nodes (m, 2) as `models.rays.triangle_kernels` reads them, and the triangles' order (t,)."""
    order = np.argsort(_morton((low + high) / 2), kind="stable")
    low, high = low[order], high[order]
    begin, end = np.array([0]), np.array([len(order)])
    boxes: list[Floats] = []
    nodes: list[Ints] = []
    made = 1
    while len(begin):
        cuts = np.stack([begin, end], axis=1).ravel()
        cuts = cuts[:-1] if cuts[-1] == len(order) else cuts
        boxes.append(
            np.hstack(
                [np.minimum.reduceat(low, cuts, axis=0)[::2], np.maximum.reduceat(high, cuts, axis=0)[::2]]
            )
        )
        inner = end - begin > _LEAF
        level = np.stack([begin, end - begin], axis=1)
        level[inner] = np.stack([made + 2 * np.arange(inner.sum()), np.zeros(inner.sum(), dtype=int)], axis=1)
        nodes.append(level)
        made += 2 * int(inner.sum())
        middle = (begin + end)[inner] // 2
        begin = np.stack([begin[inner], middle], axis=1).ravel()
        end = np.stack([middle, end[inner]], axis=1).ravel()
    return np.concatenate(boxes), np.concatenate(nodes), order


def _morton(points: Floats) -> NDArray[np.uint64]:
    """(n,) place of each point on a curve through the box of all, 2^20 cells a side."""
    low, size = points.min(axis=0), float(np.ptp(points, axis=0).max()) or 1.0
    cells = ((points - low) / size * (2**20 - 1)).astype(np.uint64)
    for shift, mask in _SPREAD:
        cells = (cells | (cells << shift)) & mask
    return np.asarray(cells[:, 0] | (cells[:, 1] << np.uint64(1)) | (cells[:, 2] << np.uint64(2)))
