"""What was felt, place by place: touched cells with the way they face, and places that the skin found free.

On an object of any form each face is explored for itself.  The pad on a face tells of every place under it whether
the face is there, touched, or is not, free.  What is neither is open (our derivation; compare the frontiers of
mobile robots, Yamauchi 1997).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from exploration.planning.known.places import Places
from primitives.arrays import Bools, Floats
from primitives.shapes import Shape

CELL = 2.0  # [mm] touched places nearer than this, that face alike, are one
_NEAR, _ALIKE = 0.8, 0.9  # [mm] from a surface, and cosine of the ways that both face, of a place on it


class SurfaceMap:
    """Grows with every stroke."""

    def __init__(self) -> None:
        self._places = Places(6)
        self._taken = 0

    def add(self, points: Floats, facing: Floats) -> None:
        """Remember (n, 3) touched places [mm] and their outward normals, roughly."""
        if not len(points):
            return
        keys = np.concatenate([np.round(points / CELL), np.round(2.0 * facing)], axis=1).astype(int)
        self._places.add(keys, np.concatenate([points, facing], axis=1))

    def take(self, lots: Sequence[tuple[Floats, Floats]]) -> None:
        """Remember those of a growing row of lots, each as `add` has them, that were not taken before."""
        for points, facing in lots[self._taken :]:
            self.add(points, facing)
        self._taken = len(lots)

    @property
    def points(self) -> Floats:
        """(n, 3) [mm]."""
        return self._places.rows[:, :3]

    @property
    def facing(self) -> Floats:
        """(n, 3) outward normals, roughly."""
        return self._places.rows[:, 3:]

    def on(self, shape: Shape, side: float, since: int = 0) -> Bools:
        """(n,) which places, from the one of number `since` on, lie on a surface.

        Its outward normal is `side` times its own.
        """
        points, facing = self.points[since:], self.facing[since:]
        if not len(points):
            return np.zeros(0, dtype=bool)
        away = np.abs(shape.signed_distance(points)) < _NEAR
        alike = side * (shape.normals(points) * facing).sum(axis=1) > _ALIKE
        return np.asarray(away & alike)


def clusters(points: Floats, within: float) -> list[Bools]:
    """Masks of (n, d) points that hang together, neighbors being `within` of each other."""
    pairs = KDTree(points).query_pairs(within, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), tuple(pairs.T)), shape=(len(points), len(points)))
    count, label = connected_components(graph, directed=False)
    return [label == k for k in range(count)]
