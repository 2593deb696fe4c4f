"""The faces of a labeled solid: connected triangles that stand for one and the same surface, with extents.

Two primitives of a tree may share a surface; their triangles are one face.  Triangles whose surface is not known
are one face of no shape, and are matched to nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from models.solid import Solid
from primitives.arrays import Floats, Ints, frozen
from primitives.shapes import Plane, Shape
from recognition.extents import extent

_SAME = 1e-6  # [mm, rad] surfaces that differ by less are one


@dataclass(frozen=True)
class Region:
    """One face, in the world."""

    shape: Shape | None
    convex: bool
    area: float  # [mm^2]
    extent: tuple[float, float] | None  # [mm]; see `recognition.extents`

    @property
    def kind(self) -> str:
        """The shape's name."""
        return "freeform" if self.shape is None else self.shape.kind


@dataclass(frozen=True)
class Regions:
    """Every face, and which one each triangle belongs to."""

    faces: tuple[Region, ...]
    of_triangle: Ints  # (t,)


def regions(solid: Solid) -> Regions:
    """The faces of a solid, in the order of their first triangles."""
    surface = _merged(solid)
    neighbors = solid.neighbors
    rows = np.repeat(np.arange(len(neighbors)), 3)
    columns = neighbors.ravel()
    joined = columns >= 0
    joined[joined] = surface[rows[joined]] == surface[columns[joined]]
    pairs = (np.ones(int(joined.sum())), (rows[joined], columns[joined]))
    count, of_triangle = connected_components(
        coo_array(pairs, shape=(len(neighbors), len(neighbors))), directed=False
    )
    corners = solid.vertices[solid.triangles]
    areas = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    faces = []
    for k in range(count):
        mine = of_triangle == k
        label = int(surface[np.flatnonzero(mine)[0]])
        area = float(areas[mine].sum())
        if label < 0:
            faces.append(Region(None, True, area, None))
            continue
        found = solid.surfaces[label]
        shape = found.shape.transformed(solid.pose)
        faces.append(Region(shape, found.convex, area, extent(shape, corners[mine])))
    return Regions(tuple(faces), frozen(of_triangle, np.int64))


def _merged(solid: Solid) -> Ints:
    """(t,) surface of each triangle, the first of those that are the same."""
    first = np.arange(len(solid.surfaces) + 1)
    for i, a in enumerate(solid.surfaces):
        for j in range(i):
            b = solid.surfaces[j]
            if a.convex == b.convex and _same(a.shape, b.shape):
                first[i] = first[j]
                break
    first[-1] = -1  # where labels of -1 look
    return np.asarray(first[solid.face_of_triangle])


def _same(a: Shape, b: Shape) -> bool:
    along = float(a.direction @ b.direction)
    if a.kind != b.kind or (along if isinstance(a, Plane) else abs(along)) < 0.9:
        return False
    step: Floats = a.local(b)  # type: ignore[arg-type]  # of one kind, as just checked
    return bool(np.abs(step).max() < _SAME)
