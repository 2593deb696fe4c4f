"""Several solids as one surface: the nearest of them is felt, and the first that a ray meets.

The solids may touch (a part on a table) but not overlap: inside an overlap the distance is that to the deeper
one's surface, and its normal.  Triangles are numbered through, solid after solid; `solid_of` says whose one is.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from models.csg import Cube
from models.solid import Solid
from primitives.arrays import Floats, Ints, frozen
from primitives.errors import PalpateError
from primitives.pose import pose
from primitives.surface import RayHits, TriangleSurface


class Scene:
    """A part with its table, fixture and neighbors; implements `primitives.surface.TriangleSurface`."""

    def __init__(self, surfaces: Sequence[TriangleSurface]) -> None:
        if not surfaces:
            raise PalpateError("a scene needs a solid or more")
        self.surfaces = tuple(surfaces)
        self._first_vertex = np.cumsum([0, *(len(s.vertices) for s in surfaces)])
        self._first_triangle = np.cumsum([0, *(len(s.triangles) for s in surfaces)])

    @cached_property
    def vertices(self) -> Floats:
        """(v, 3) [mm]."""
        return frozen(np.concatenate([s.vertices for s in self.surfaces]))

    @property
    def bounds(self) -> Floats:
        """(2, 3) least and greatest corner of all [mm]."""
        return frozen(np.stack([self.vertices.min(axis=0), self.vertices.max(axis=0)]))

    @cached_property
    def triangles(self) -> Ints:
        """(t, 3) vertex indices."""
        moved = [s.triangles + first for s, first in zip(self.surfaces, self._first_vertex[:-1], strict=True)]
        return frozen(np.concatenate(moved), np.int64)

    @cached_property
    def neighbors(self) -> Ints:
        """(t, 3) triangle across the edge from corner i to corner i + 1; -1 at an open rim."""
        moved = [
            np.where(s.neighbors < 0, -1, s.neighbors + first)
            for s, first in zip(self.surfaces, self._first_triangle[:-1], strict=True)
        ]
        return frozen(np.concatenate(moved), np.int64)

    def solid_of(self, triangle: Ints) -> Ints:
        """(n,) which solid each of (n,) triangles is of; -1 for -1."""
        return np.asarray(np.searchsorted(self._first_triangle, triangle, side="right") - 1)

    def signed_distance(self, points: Floats) -> Floats:
        """The least distance of (n, 3) points [mm] to any solid, negative inside one: (n,) [mm]."""
        return np.asarray(np.min([s.signed_distance(points) for s in self.surfaces], axis=0))

    def normals(self, points: Floats) -> Floats:
        """Outward unit normals at the surface points nearest to (n, 3) points: (n, 3)."""
        nearest = np.argmin([s.signed_distance(points) for s in self.surfaces], axis=0)
        out = np.empty((len(points), 3))
        for i, surface in enumerate(self.surfaces):
            out[nearest == i] = surface.normals(points[nearest == i])
        return out

    def cast_rays(self, origins: Floats, directions: Floats) -> RayHits:
        """First hits of (n, 3) origins [mm] along (n, 3) unit directions."""
        hits = [s.cast_rays(origins, directions) for s in self.surfaces]
        distance = np.stack([h.distance for h in hits])
        first, rows = np.argmin(distance, axis=0), np.arange(len(origins))
        element = np.stack([h.element for h in hits])[first, rows]
        return RayHits(
            frozen(distance[first, rows]),
            frozen(np.stack([h.normals for h in hits])[first, rows]),
            frozen(np.where(element < 0, -1, element + self._first_triangle[first]), np.int64),
        )

    def first_hits(
        self, origins: NDArray[np.float32], directions: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        """Distance (n,) and triangle (n,), or inf and -1, of (n, 3) contiguous rays."""
        distance, triangle = self.surfaces[0].first_hits(origins, directions)
        for surface, first in zip(self.surfaces[1:], self._first_triangle[1:-1], strict=True):
            other, element = surface.first_hits(origins, directions)
            nearer = other < distance
            distance[nearer], triangle[nearer] = other[nearer], element[nearer] + np.int32(first)
        return distance, triangle


def table_under(part: Solid, margin: float = 150.0, thickness: float = 20.0) -> Solid:
    """A square table that a part lies on: its top is at the part's lowest point, `margin` [mm] beyond its box."""
    low, high = part.bounds
    x, y, _ = (low + high) / 2
    side = float((high - low)[:2].max()) + 2 * margin
    table = Cube((side, side, thickness), name="table")
    return Solid.from_csg(table).placed(pose(None, (x, y, low[2] - thickness / 2)))
