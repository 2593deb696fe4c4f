"""What every posed copy of a solid shares: triangles in the part frame, the surfaces they stand for, the trees."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from functools import cached_property
from typing import Any, NamedTuple, TypeVar

import numpy as np

from models.boundaries.topology import triangle_neighbors
from models.raycast import RayCaster, caster
from models.rays.triangle_tree import TriangleTree
from primitives.arrays import Floats, Ints, frozen
from primitives.shapes import Shape


class LabeledSurface(NamedTuple):
    """The exact surface behind a set of triangles, in the part frame."""

    shape: Shape | None  # None for freeform: the triangles stand for themselves
    convex: bool  # false where the material is outside a curved shape (a hole); planes are convex
    leaf: int  # which primitive of the tree it came from, in the order of `Csg.leaves`; -1 without a tree

    def normals(self, points: Floats, otherwise: Floats) -> Floats:
        """(n, 3) outward at (n, 3) points, or `otherwise` where it is freeform."""
        if self.shape is None:
            return otherwise
        return self.shape.normals(points) * (1.0 if self.convex else -1.0)


_T = TypeVar("_T")


class Body:
    """What every posed copy of a solid shares, in the part frame."""

    def __init__(
        self,
        make_mesh: Callable[[], Any],
        vertices: Floats,
        triangles: Ints,
        face_of_triangle: Ints,
        surfaces: tuple[LabeledSurface, ...],
    ) -> None:
        self._make_mesh = make_mesh
        self.vertices: Floats = frozen(vertices)
        self.triangles: Ints = frozen(triangles, np.int64)
        self.face_of_triangle: Ints = frozen(face_of_triangle, np.int64)
        self.surfaces = surfaces
        self._kept: dict[Hashable, Any] = {}

    def remembered(self, key: Hashable, make: Callable[[], _T]) -> _T:
        """What `make` returned when it was first asked for under this key."""
        if key not in self._kept:
            self._kept[key] = make()
        kept: _T = self._kept[key]
        return kept

    @cached_property
    def mesh(self) -> Any:
        """The manifold with these triangles."""
        return self._make_mesh()

    @cached_property
    def caster(self) -> RayCaster:
        """Over the triangles."""
        return caster(self.vertices, self.triangles)

    @cached_property
    def tree(self) -> TriangleTree:
        """Over the triangles."""
        return TriangleTree(self.vertices, self.triangles)

    @cached_property
    def neighbors(self) -> Ints:
        """(t, 3) triangle across the edge from corner i to corner i + 1."""
        return frozen(triangle_neighbors(self.triangles), np.int64)

    @cached_property
    def triangle_areas(self) -> Floats:
        """(t,) [mm^2]."""
        a, b, c = np.moveaxis(self.vertices[self.triangles], 1, 0)
        return frozen(np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2)

    @cached_property
    def triangle_normals(self) -> Floats:
        """(t, 3) unit."""
        a, b, c = np.moveaxis(self.vertices[self.triangles], 1, 0)
        normals = np.cross(b - a, c - a)
        return frozen(normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300))

    def exact_normals(self, points: Floats, triangles: Ints) -> Floats:
        """(n, 3) outward normals at (n, 3) points on (n,) triangles, of the surfaces they stand for."""
        normals = self.triangle_normals[triangles]
        labels = self.face_of_triangle[triangles]
        for label in np.unique(labels[labels >= 0]):
            surface = self.surfaces[label]
            rows = labels == label
            normals[rows] = surface.normals(points[rows], normals[rows])
        return normals
