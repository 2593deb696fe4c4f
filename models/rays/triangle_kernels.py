"""The compiled loops of `models.rays.triangle_tree`: nearest points and first hits.

A node is (first, count) of its triangles in `order` where it is a leaf, else (left child, 0) with the right
child next to the left.  Nothing is allocated inside a loop.
"""

import numpy as np
from numba import njit

_STACK = 64  # deepest path; halving 2^40 triangles needs fewer
_BEYOND, _LEAST = 1.0 + 1e-9, 1e-300  # of a squared distance, and [mm^2]: what is surely farther
_WIDER = 1e-9  # share of a triangle's side by which rays may miss it and still hit


@njit(cache=True, nogil=True)
def nearest_in_tree(points, corners, boxes, nodes, order):  # type: ignore[no-untyped-def]
    """Distance, triangle, point and feature of the triangles nearest to (n, 3) points."""
    n = len(points)
    distance, triangle = np.full(n, np.inf), np.full(n, -1, dtype=np.int64)
    closest, feature = np.zeros((n, 3)), np.zeros(n, dtype=np.int64)
    stack, reach = np.empty(_STACK, dtype=np.int64), np.empty(_STACK)
    for i in range(n):
        p, best = points[i], np.inf
        if i > 0 and triangle[i - 1] >= 0:
            x, y, z, _ = _closest(p, corners[triangle[i - 1]])
            best = ((p[0] - x) ** 2 + (p[1] - y) ** 2 + (p[2] - z) ** 2) * _BEYOND + _LEAST
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


@njit(cache=True, inline="always")
def _dot(a, b, c, x, y, z):  # type: ignore[no-untyped-def]
    return a * x + b * y + c * z


@njit(cache=True)
def _closest(p, corners):  # type: ignore[no-untyped-def]
    """Ericson 2005, section 5.1.5: the regions of corners, edges and the inside, in turn."""
    ax, ay, az = corners[0, 0], corners[0, 1], corners[0, 2]
    bx, by, bz = corners[1, 0] - ax, corners[1, 1] - ay, corners[1, 2] - az
    cx, cy, cz = corners[2, 0] - ax, corners[2, 1] - ay, corners[2, 2] - az
    px, py, pz = p[0] - ax, p[1] - ay, p[2] - az
    d1, d2 = _dot(bx, by, bz, px, py, pz), _dot(cx, cy, cz, px, py, pz)
    bb, bc, cc = _dot(bx, by, bz, bx, by, bz), _dot(bx, by, bz, cx, cy, cz), _dot(cx, cy, cz, cx, cy, cz)
    d3, d4, d5, d6 = d1 - bb, d2 - bc, d1 - bc, d2 - cc
    u, v, feature = 0.0, 0.0, 0
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    if d1 <= 0 and d2 <= 0:
        feature = 4
    elif d3 >= 0 and d4 <= d3:
        u, feature = 1.0, 5
    elif vc <= 0 and d1 >= 0 and d3 <= 0:
        u, feature = d1 / (d1 - d3), 1
    elif d6 >= 0 and d5 <= d6:
        v, feature = 1.0, 6
    elif vb <= 0 and d2 >= 0 and d6 <= 0:
        v, feature = d2 / (d2 - d6), 3
    elif va <= 0 and d4 >= d3 and d5 >= d6:
        v = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        u, feature = 1.0 - v, 2
    else:
        u, v = vb / (va + vb + vc), vc / (va + vb + vc)
    return ax + u * bx + v * cx, ay + u * by + v * cy, az + u * bz + v * cz, feature


@njit(cache=True, nogil=True)
def first_hits_in_tree(origins, directions, corners, boxes, nodes, order):  # type: ignore[no-untyped-def]
    """Distance and triangle where (n, 3) rays first hit."""
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
def _ray_triangle(o, d, corners):  # type: ignore[no-untyped-def]
    """Moeller and Trumbore 1997, a little wider than the triangle so that no ray slips between neighbors."""
    ax, ay, az = corners[0, 0], corners[0, 1], corners[0, 2]
    bx, by, bz = corners[1, 0] - ax, corners[1, 1] - ay, corners[1, 2] - az
    cx, cy, cz = corners[2, 0] - ax, corners[2, 1] - ay, corners[2, 2] - az
    sx, sy, sz = o[0] - ax, o[1] - ay, o[2] - az
    px, py, pz = d[1] * cz - d[2] * cy, d[2] * cx - d[0] * cz, d[0] * cy - d[1] * cx
    det = _dot(bx, by, bz, px, py, pz)
    if det == 0:
        return np.inf
    u = _dot(sx, sy, sz, px, py, pz) / det
    if u < -_WIDER or u > 1 + _WIDER:
        return np.inf
    qx, qy, qz = sy * bz - sz * by, sz * bx - sx * bz, sx * by - sy * bx
    v = _dot(d[0], d[1], d[2], qx, qy, qz) / det
    if v < -_WIDER or u + v > 1 + _WIDER:
        return np.inf
    t = _dot(cx, cy, cz, qx, qy, qz) / det
    return t if t >= 0 else np.inf
