"""What has been touched so far: cells of surface under taxels, and the planes that support the object."""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from exploration.planning.known.places import Places
from exploration.planning.ways.transit import Support
from primitives.arrays import Bools, Floats

_CELL = 2.0  # [mm] touched points closer than this are one


class Touched:
    """Grows with every stroke."""

    def __init__(self) -> None:
        self._places = Places()
        self._tree: KDTree | None = None
        self.supports: list[Support] = []

    def add(self, cells: Floats, support: Support) -> None:
        """Remember (n, 3) touched points and the plane that the pad lay against."""
        self._places.add(np.round(cells / _CELL).astype(int), cells)
        self._tree = None
        self.supports.append(support)

    def covers(self, points: Floats, within: float) -> Bools:
        """(n,) whether something was touched `within` mm of each of (n, 3) points."""
        return self.away(points, within) <= within

    def away(self, points: Floats, most: float = np.inf) -> Floats:
        """(n,) [mm] to what was touched nearest to each of (n, 3) points; inf past `most`."""
        if not len(self._places) or not len(points):
            return np.full(len(points), np.inf)
        if self._tree is None:
            self._tree = KDTree(self._places.rows)
        return np.asarray(self._tree.query(points, distance_upper_bound=np.nextafter(most, np.inf))[0])
