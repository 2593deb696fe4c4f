"""The graph of facets: which meet, along how much of their rims, and at what angle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.recovery.flats import Flats
from primitives.arrays import Floats, Ints


@dataclass(frozen=True)
class Creases:
    """Pairs of facets that meet, each pair once from either side, sorted by the first."""

    start: Ints  # (f + 1,) where each facet's pairs begin
    other: Ints  # (m,) the facet beyond
    length: Floats  # (m,) [mm] of their common rim
    turn: Floats  # (m,) [rad] from one normal to the next; positive where the solid is convex

    def around(self, facet: int) -> slice:
        """The pairs of one facet."""
        return slice(int(self.start[facet]), int(self.start[facet + 1]))

    def mean_turn(self) -> Floats:
        """(f,) [rad] by which each facet turns into its neighbors, each by the length of their common rim."""
        count = len(self.start) - 1
        first = np.repeat(np.arange(count), np.diff(self.start))
        rim = np.bincount(first, self.length, count)
        return np.bincount(first, self.length * np.abs(self.turn), count) / np.maximum(rim, 1e-300)


def find_creases(vertices: Floats, triangles: Ints, neighbors: Ints, flats: Flats) -> Creases:
    """Every meeting of two facets."""
    of = flats.of_triangle
    rows, sides = np.nonzero((of[neighbors] != of[:, None]) & (neighbors >= 0))
    mine, other = of[rows], of[neighbors[rows, sides]]
    begin, end = vertices[triangles[rows, sides]], vertices[triangles[rows, (sides + 1) % 3]]
    along = end - begin
    a, b = flats.normal[mine], flats.normal[other]
    bend = np.einsum("ij,ij->i", np.cross(a, b), along)  # length times sine, positive where convex
    key, inverse = np.unique(mine * len(flats) + other, return_inverse=True)
    length = np.bincount(inverse.reshape(-1), np.linalg.norm(along, axis=1), len(key))
    sign = 1.0 - 2.0 * (np.bincount(inverse.reshape(-1), bend, len(key)) < 0)
    first, second = np.divmod(key, len(flats))
    a, b = flats.normal[first], flats.normal[second]
    angle = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.einsum("ij,ij->i", a, b))
    start = np.searchsorted(first, np.arange(len(flats) + 1))
    return Creases(np.asarray(start), second, np.asarray(length, dtype=np.float64), sign * angle)
