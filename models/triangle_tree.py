"""A bounding-volume tree over triangles: nearest points with their sign, and first hits of rays.

The sign of the distance comes from the angle-weighted pseudonormal of the nearest feature, which is right
for every closed mesh (Baerentzen and Aanaes 2005).  Boxes are split at the median centroid along the longest
side; the kernels are compiled on first use and cached.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from primitives.arrays import Floats, Ints

_LEAF = 4  # triangles a leaf holds at most
_STACK = 64  # deepest path; a median split of 2^40 triangles needs fewer


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
        self._boxes, self._nodes, self._order = _build(low, high, (low + high) / 2)

    def nearest(self, points: Floats) -> Nearest:
        """The nearest point of the mesh to each of (n, 3) points [mm]."""
        wanted = np.ascontiguousarray(points, dtype=np.float64)
        return Nearest(*_nearest(wanted, self._corners, self._boxes, self._nodes, self._order))

    def signed_distance(self, points: Floats) -> Floats:
        """(n,) distance of (n, 3) points [mm], negative inside a closed mesh."""
        found = self.nearest(points)
        towards = np.einsum("ij,ij->i", points - found.points, self._pseudonormals_at(found))
        return np.where(towards < 0, -found.distance, found.distance)

    def first_hits(
        self, origins: NDArray[np.float32], directions: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        """Distance (n,) and triangle (n,), or inf and -1, of (n, 3) rays."""
        distance, triangle = _first_hits(
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
        ends = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2), axis=2).reshape(-1, 2)
        edge_of = np.unique(ends, axis=0, return_inverse=True)[1].reshape(-1)
        at_edge = np.zeros((edge_of.max(initial=-1) + 1, 3))
        np.add.at(at_edge, edge_of, np.repeat(normals, 3, axis=0))
        by_edge = at_edge[edge_of].reshape(-1, 3, 3)
        return np.concatenate([normals[:, None], by_edge, at_vertex[triangles]], axis=1)


@njit(cache=True)
def _build(low, high, centers):  # type: ignore[no-untyped-def]
    count = len(centers)
    order = np.arange(count)
    boxes = np.empty((max(2 * count, 1), 6))
    nodes = np.empty((max(2 * count, 1), 2), dtype=np.int64)  # leaf: (first, count); inner: (left, 0)
    begin, end = np.empty(max(2 * count, 1), dtype=np.int64), np.empty(max(2 * count, 1), dtype=np.int64)
    begin[0], end[0], used, node = 0, count, 1, 0
    while node < used:
        first, last = begin[node], end[node]
        for axis in range(3):
            least, most = np.inf, -np.inf
            for i in range(first, last):
                least, most = min(least, low[order[i], axis]), max(most, high[order[i], axis])
            boxes[node, axis], boxes[node, 3 + axis] = least, most
        if last - first <= _LEAF:
            nodes[node, 0], nodes[node, 1] = first, last - first
        else:
            sides = boxes[node, 3:] - boxes[node, :3]
            axis = int(np.argmax(sides))
            members = order[first:last].copy()
            order[first:last] = members[np.argsort(centers[members, axis])]
            middle = (first + last) // 2
            nodes[node, 0], nodes[node, 1] = used, 0
            begin[used], end[used], begin[used + 1], end[used + 1] = first, middle, middle, last
            used += 2
        node += 1
    return boxes[:used].copy(), nodes[:used].copy(), order


@njit(cache=True)
def _nearest(points, corners, boxes, nodes, order):  # type: ignore[no-untyped-def]
    n = len(points)
    distance, triangle = np.full(n, np.inf), np.full(n, -1, dtype=np.int64)
    closest, feature = np.zeros((n, 3)), np.zeros(n, dtype=np.int64)
    stack, reach = np.empty(_STACK, dtype=np.int64), np.empty(_STACK)
    for i in range(n):
        p, best = points[i], np.inf
        stack[0], reach[0], depth = 0, 0.0, 1
        while depth > 0:
            depth -= 1
            node = stack[depth]
            if reach[depth] >= best:
                continue
            first, count = nodes[node]
            if count > 0:
                for k in range(first, first + count):
                    t = order[k]
                    x, y, z, where = _closest(p, corners[t])
                    away = (p[0] - x) ** 2 + (p[1] - y) ** 2 + (p[2] - z) ** 2
                    if away < best:
                        best, triangle[i], feature[i] = away, t, where
                        closest[i, 0], closest[i, 1], closest[i, 2] = x, y, z
                continue
            left, right = _box_away(p, boxes[first]), _box_away(p, boxes[first + 1])
            near, far = (first, first + 1) if left <= right else (first + 1, first)
            stack[depth], reach[depth] = far, max(left, right)
            stack[depth + 1], reach[depth + 1] = near, min(left, right)
            depth += 2
        distance[i] = np.sqrt(best)
    return distance, triangle, closest, feature


@njit(cache=True, inline="always")
def _box_away(p, box):  # type: ignore[no-untyped-def]
    total = 0.0
    for axis in range(3):
        beyond = max(box[axis] - p[axis], p[axis] - box[3 + axis], 0.0)
        total += beyond * beyond
    return total


@njit(cache=True)
def _closest(p, triangle):  # type: ignore[no-untyped-def]
    """Ericson 2005, section 5.1.5: the regions of corners, edges and the inside, in turn."""
    a, b, c = triangle[0], triangle[1], triangle[2]
    ab, ac, ap = b - a, c - a, p - a
    d1, d2 = np.dot(ab, ap), np.dot(ac, ap)
    if d1 <= 0 and d2 <= 0:
        return a[0], a[1], a[2], 4
    bp = p - b
    d3, d4 = np.dot(ab, bp), np.dot(ac, bp)
    if d3 >= 0 and d4 <= d3:
        return b[0], b[1], b[2], 5
    vc = d1 * d4 - d3 * d2
    if vc <= 0 and d1 >= 0 and d3 <= 0:
        q = a + d1 / (d1 - d3) * ab
        return q[0], q[1], q[2], 1
    cp = p - c
    d5, d6 = np.dot(ab, cp), np.dot(ac, cp)
    if d6 >= 0 and d5 <= d6:
        return c[0], c[1], c[2], 6
    vb = d5 * d2 - d1 * d6
    if vb <= 0 and d2 >= 0 and d6 <= 0:
        q = a + d2 / (d2 - d6) * ac
        return q[0], q[1], q[2], 3
    va = d3 * d6 - d5 * d4
    if va <= 0 and d4 >= d3 and d5 >= d6:
        q = b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b)
        return q[0], q[1], q[2], 2
    q = a + (vb * ab + vc * ac) / (va + vb + vc)
    return q[0], q[1], q[2], 0


@njit(cache=True)
def _first_hits(origins, directions, corners, boxes, nodes, order):  # type: ignore[no-untyped-def]
    n = len(origins)
    distance, triangle = np.full(n, np.inf, dtype=np.float32), np.full(n, -1, dtype=np.int32)
    stack = np.empty(_STACK, dtype=np.int64)
    o, d, over = np.empty(3), np.empty(3), np.empty(3)
    for i in range(n):
        for axis in range(3):
            o[axis], d[axis] = origins[i, axis], directions[i, axis]
            over[axis] = 1.0 / d[axis] if d[axis] != 0 else np.inf
        best, stack[0], depth = np.inf, 0, 1
        while depth > 0:
            depth -= 1
            node = stack[depth]
            if _box_enter(o, d, over, boxes[node]) > best:
                continue
            first, count = nodes[node]
            if count > 0:
                for k in range(first, first + count):
                    hit = _ray_triangle(o, d, corners[order[k]])
                    if hit < best:
                        best, triangle[i] = hit, order[k]
                continue
            left, right = _box_enter(o, d, over, boxes[first]), _box_enter(o, d, over, boxes[first + 1])
            near, far = (first, first + 1) if left <= right else (first + 1, first)
            if max(left, right) < np.inf:
                stack[depth] = far
                depth += 1
            if min(left, right) < np.inf:
                stack[depth] = near
                depth += 1
        distance[i] = best
    return distance, triangle


@njit(cache=True, inline="always")
def _box_enter(o, d, over, box):  # type: ignore[no-untyped-def]
    enter, leave = 0.0, np.inf
    for axis in range(3):
        if d[axis] == 0:
            if o[axis] < box[axis] or o[axis] > box[3 + axis]:
                return np.inf
            continue
        s, t = (box[axis] - o[axis]) * over[axis], (box[3 + axis] - o[axis]) * over[axis]
        enter, leave = max(enter, min(s, t)), min(leave, max(s, t))
    return enter if enter <= leave * (1 + 1e-12) else np.inf


@njit(cache=True)
def _ray_triangle(o, d, triangle):  # type: ignore[no-untyped-def]
    """Moeller and Trumbore 1997, closed at the edges so that no ray slips between neighbors."""
    a = triangle[0]
    ab, ac, ao = triangle[1] - a, triangle[2] - a, o - a
    px, py, pz = d[1] * ac[2] - d[2] * ac[1], d[2] * ac[0] - d[0] * ac[2], d[0] * ac[1] - d[1] * ac[0]
    det = ab[0] * px + ab[1] * py + ab[2] * pz
    if det == 0:
        return np.inf
    u = (ao[0] * px + ao[1] * py + ao[2] * pz) / det
    if u < -1e-9 or u > 1 + 1e-9:
        return np.inf
    qx, qy, qz = ao[1] * ab[2] - ao[2] * ab[1], ao[2] * ab[0] - ao[0] * ab[2], ao[0] * ab[1] - ao[1] * ab[0]
    v = (d[0] * qx + d[1] * qy + d[2] * qz) / det
    if v < -1e-9 or u + v > 1 + 1e-9:
        return np.inf
    t = (ac[0] * qx + ac[1] * qy + ac[2] * qz) / det
    return t if t >= 0 else np.inf
