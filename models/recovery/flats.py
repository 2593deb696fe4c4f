"""Triangles that lie in one plane, made one facet: what a tessellation is before it is cut into triangles.

A facet grows from the largest triangle left over neighbors whose corners are all within `flat` of its plane and
whose normals agree; a sliver's normal is noise, so only its corners count.  The plane is then that of the whole
facet, and growing goes on until nothing is added.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from primitives.arrays import Bools, Floats, Ints

_ROUNDS = 4  # times a facet's plane is found again
_BENT = 3e-3  # [1] of turn times reach, that corners of one plane may be off


@dataclass(frozen=True)
class Flats:
    """Flat facets and the corners of each."""

    of_triangle: Ints  # (t,) facet of each triangle
    normal: Floats  # (f, 3) outward unit normal
    center: Floats  # (f, 3) centroid of the area [mm]
    area: Floats  # (f,) [mm^2]
    corners: Ints  # corner numbers of all facets, one facet after the other
    start: Ints  # (f + 1,) where each facet's begin
    thin: Bools  # (f,) slivers alone, whose normal is noise

    def __len__(self) -> int:
        return len(self.area)


def find_flats(
    vertices: Floats, triangles: Ints, neighbors: Ints, flat: float, noise: float, angle: float
) -> Flats:
    """Facets whose corners are within `flat` [mm] of a plane and whose normals are within `angle` [rad].

    A triangle so thin that `noise` [mm] in its corners turns it by more than that is a sliver.
    """
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    cross = np.cross(b - a, c - a)
    twice = np.linalg.norm(cross, axis=1)
    longest = np.sqrt(np.max([((p - q) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a))], axis=0))
    sliver = twice / np.maximum(longest, 1e-300) < noise / np.tan(angle)
    order = np.lexsort((-twice, sliver))
    of = _cluster(
        vertices, triangles, neighbors, cross, sliver, order.astype(np.int64), flat, float(np.cos(angle))
    )
    count = int(of.max(initial=-1)) + 1
    total = np.stack([np.bincount(of, cross[:, k], count) for k in range(3)], axis=1)
    length = np.linalg.norm(total, axis=1)
    area = np.maximum(np.bincount(of, twice, count), 1e-300)
    middle = (a + b + c) / 3 * twice[:, None]
    center = np.stack([np.bincount(of, middle[:, k], count) for k in range(3)], axis=1) / area[:, None]
    empty = area < 1e-200
    if empty.any():
        first = np.unique(of, return_index=True)[1]
        center[empty] = a[first[empty]]
    pairs = np.unique(np.stack([np.repeat(of, 3), triangles.ravel()], axis=1), axis=0)
    return Flats(
        of,
        total / np.maximum(length, 1e-300)[:, None],
        center,
        area / 2,
        np.ascontiguousarray(pairs[:, 1]),
        np.searchsorted(pairs[:, 0], np.arange(count + 1)),
        np.bincount(of, ~sliver, count) == 0,
    )


def corner_noise(vertices: Floats, flats: Flats, turn: Floats, least: float, most: float) -> float:
    """[mm] of rounding in the corners, as the facets with more than four of them show it.

    Not those that may be triangles of a fine curved mesh: off by a good part of what their `turn` [rad] from
    facet to facet bends them.
    """
    corners, start, normal = flats.corners, flats.start, flats.normal
    facet = np.repeat(np.arange(len(flats)), np.diff(start))
    offset = vertices[corners] - flats.center[facet]
    away = np.abs(np.einsum("ij,ij->i", offset, normal[facet]))
    reach = np.sqrt(np.maximum.reduceat(np.einsum("ij,ij->i", offset, offset), start[:-1]))
    bent = np.maximum.reduceat(away, start[:-1]) > _BENT * turn * reach
    proven = ((np.diff(start) > 4) & ~bent)[facet]
    spread = 2 * float(np.quantile(away[proven], 0.8)) if proven.any() else 0.0
    return float(np.clip(spread, least, most))


@njit(cache=True)
def _cluster(vertices, triangles, neighbors, cross, sliver, order, flat, cosine):  # type: ignore[no-untyped-def]
    n = len(triangles)
    label = np.full(n, -1, dtype=np.int64)
    stack = np.empty(n, dtype=np.int64)
    members = np.empty(n, dtype=np.int64)
    count = 0
    for seed in order:
        if label[seed] >= 0:
            continue
        label[seed] = count
        members[0] = seed
        size = 1
        normal = cross[seed].copy()
        for _ in range(_ROUNDS):
            length = np.sqrt((normal * normal).sum())
            if length == 0.0:
                break
            unit = normal / length
            offset, weight = 0.0, 0.0
            for i in range(size):
                t = members[i]
                w = np.sqrt((cross[t] * cross[t]).sum()) + 1e-300
                weight += 3 * w
                for k in range(3):
                    offset += w * (vertices[triangles[t, k]] * unit).sum()
            offset /= weight
            before = size
            top = 0
            for i in range(size):
                stack[top] = members[i]
                top += 1
            while top > 0:
                top -= 1
                t = stack[top]
                for k in range(3):
                    other = neighbors[t, k]
                    if other < 0 or label[other] >= 0:
                        continue
                    c = cross[other]
                    size_c = np.sqrt((c * c).sum())
                    if not sliver[other] and (c * unit).sum() < cosine * size_c:
                        continue
                    inside = True
                    for j in range(3):
                        if abs((vertices[triangles[other, j]] * unit).sum() - offset) > flat:
                            inside = False
                    if inside:
                        label[other] = count
                        members[size] = other
                        size += 1
                        stack[top] = other
                        top += 1
                        normal += c
            if size == before:
                break
        count += 1
    return label
