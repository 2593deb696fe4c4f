"""A solid with a triangle boundary, from a CSG tree or a mesh, that can be touched.

A solid from a tree knows which exact surface every triangle stands for, and its normals are those of that
surface; a mesh's are its triangles'.  `placed` shares the body: rays and points are moved into the part frame,
so a pose costs nothing and single precision is kept where coordinates are small.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from models.body import Body, LabeledSurface
from models.csg import Csg
from models.meshing.manifold import (
    body_again,
    body_of_field,
    body_of_labels,
    body_of_mesh,
    body_of_tree,
    body_within,
    combined,
    composed,
)
from models.splinters import splinters
from primitives.arrays import Bools, Floats, Ints, frozen
from primitives.errors import PalpateError
from primitives.pose import inverse, rotate, transform_points
from primitives.surface import RayHits

TOLERANCE = 0.002  # [mm] between a facet and the surface that it stands for


@dataclass(frozen=True, eq=False)
class Solid:
    """A posed solid; implements `primitives.surface.TriangleSurface`."""

    body: Body
    pose: Floats  # (4, 4) world_from_part
    csg: Csg | None = None  # in the part frame

    @staticmethod
    def from_csg(tree: Csg, tolerance: float = TOLERANCE) -> Solid:
        """The solid of a tree, its facets within `tolerance` [mm] of the exact surfaces."""
        body = body_of_tree(tree, tolerance)
        if body is None:
            raise PalpateError("the tree has no material left; make intersections overlap and cuts smaller")
        return Solid(body, frozen(np.eye(4)), tree)

    @staticmethod
    def from_kept(
        tree: Csg, vertices: Floats, triangles: Ints, labels: Ints, tolerance: float = TOLERANCE
    ) -> Solid:
        """What `from_csg` made before, from (v, 3) vertices, (t, 3) triangles and their (t,) labels."""
        return Solid(body_again(tree, tolerance, vertices, triangles, labels), frozen(np.eye(4)), tree)

    @staticmethod
    def from_mesh(vertices: ArrayLike, triangles: ArrayLike) -> Solid:
        """The solid inside a closed mesh of (v, 3) vertices [mm] and (t, 3) triangles, normals out."""
        return Solid(body_of_mesh(vertices, triangles), frozen(np.eye(4)))

    @staticmethod
    def from_field(field: Callable[[Floats], Floats], low: Floats, high: Floats, step: float) -> Solid:
        """The solid where a field of (n, 3) places [mm] is negative, found on a grid between two (3,) corners."""
        return Solid(body_of_field(field, low, high, step), frozen(np.eye(4)))

    @staticmethod
    def from_labeled(
        vertices: Floats, triangles: Ints, labels: Ints, surfaces: tuple[LabeledSurface, ...]
    ) -> Solid:
        """As `from_mesh`, each triangle standing for the surface that its label (t,) counts; -1 for none."""
        return Solid(body_of_labels(vertices, triangles, labels, surfaces), frozen(np.eye(4)))

    def placed(self, world_from_part: ArrayLike) -> Self:
        """The same part at another pose, whatever this one's is."""
        return type(self)(self.body, frozen(world_from_part), self.csg)

    @property
    def volume(self) -> float:
        """[mm^3]."""
        return float(self.body.mesh.volume())

    @property
    def area(self) -> float:
        """[mm^2]."""
        return float(self.body.triangle_areas.sum())

    @property
    def shells(self) -> int:
        """Closed surfaces that bound it: one, unless it lies in pieces or has a cavity."""
        return len(self.body.mesh.decompose())

    @property
    def parts(self) -> int:
        """Bodies that do not hang together, however many cavities they have; splinters do not count."""
        apart = self.body.mesh.decompose()
        return sum(part.volume() > 0.0 and not thin for part, thin in zip(apart, _thin(apart), strict=True))

    def without_splinters(self) -> Solid:
        """Of its bodies that are more than rounding left, without labels or a tree; itself where all are."""
        apart = self.body.mesh.decompose()
        thin = _thin(apart)
        if not thin.any():
            return self
        kept = [part for part, left_out in zip(apart, thin, strict=True) if not left_out]
        return Solid(composed(kept), self.pose)

    def largest_part(self) -> Solid:
        """The largest of the bodies that do not hang together, without labels or a tree."""
        return Solid(composed([max(self.body.mesh.decompose(), key=lambda part: part.volume())]), self.pose)

    def simplified(self, by: float) -> Solid:
        """With fewer triangles, its corners moved by up to so much [mm]; without labels."""
        return Solid(composed([self.body.mesh.simplify(by)]), self.pose)

    @property
    def genus(self) -> int:
        """Handles, over all shells: 1 for a ring."""
        return int(self.body.mesh.genus())

    @property
    def bounds(self) -> Floats:
        """(2, 3) least and greatest corner in the world [mm]."""
        return frozen(np.stack([self.vertices.min(axis=0), self.vertices.max(axis=0)]))

    @property
    def extent(self) -> Floats:
        """(3,) sides of the part's own box [mm]."""
        return frozen(np.ptp(self.body.vertices, axis=0))

    @cached_property
    def center(self) -> Floats:
        """(3,) centroid of the volume in the world [mm]."""
        a, b, c = np.moveaxis(self.vertices[self.triangles], 1, 0)
        middle = (a + b + c) / 4
        weight = np.einsum("ij,ij->i", a, np.cross(b, c))
        return frozen(weight @ middle / weight.sum())

    @cached_property
    def vertices(self) -> Floats:
        """(v, 3) in the world [mm]."""
        return self.body.vertices if self._home else frozen(transform_points(self.pose, self.body.vertices))

    @property
    def triangles(self) -> Ints:
        """(t, 3) vertex indices."""
        return self.body.triangles

    @property
    def neighbors(self) -> Ints:
        """(t, 3) triangle across the edge from corner i to corner i + 1; -1 at an open rim."""
        return self.body.neighbors

    @property
    def face_of_triangle(self) -> Ints:
        """(t,) index into `surfaces`; -1 where the triangle stands for itself."""
        return self.body.face_of_triangle

    @property
    def surfaces(self) -> tuple[LabeledSurface, ...]:
        """The exact surfaces in the part frame; none for a mesh."""
        return self.body.surfaces

    def signed_distance(self, points: Floats) -> Floats:
        """Distance of (n, 3) points [mm] to the surface, negative inside: (n,) [mm]."""
        return self.body.tree.signed_distance(self._to_part(points))

    def normals(self, points: Floats) -> Floats:
        """Outward unit normals at the surface points nearest to (n, 3) points: (n, 3)."""
        found = self.body.tree.nearest(self._to_part(points))
        return rotate(self.pose, self.body.exact_normals(found.points, found.triangle))

    def cast_rays(self, origins: Floats, directions: Floats) -> RayHits:
        """First hits of (n, 3) origins [mm] along (n, 3) unit directions."""
        reached, triangle = self.first_hits(
            np.ascontiguousarray(origins, dtype=np.float32),
            np.ascontiguousarray(directions, dtype=np.float32),
        )
        distance, hit = reached.astype(np.float64), triangle >= 0
        normals = np.zeros((len(triangle), 3))
        points = self._to_part(origins[hit] + distance[hit, None] * directions[hit])
        normals[hit] = rotate(self.pose, self.body.exact_normals(points, triangle[hit].astype(np.int64)))
        return RayHits(frozen(distance), frozen(normals), frozen(triangle, np.int64))

    def first_hits(
        self, origins: NDArray[np.float32], directions: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        """Distance (n,) and triangle (n,), or inf and -1, of (n, 3) contiguous rays."""
        if self._home:
            return self.body.caster.first_hits(origins, directions)
        return self.body.caster.first_hits(*_rays_to_part(origins, directions, self.pose))

    def boolean(self, other: Solid, operation: str) -> Solid:
        """`union`, `intersection` or `difference` with another solid, both where they are placed."""
        body = combined(self._posed_mesh(), other._posed_mesh(), operation)
        return Solid(body, frozen(np.eye(4)))

    def shared_volume(self, other: Solid) -> float:
        """Of the intersection with another solid [mm^3]."""
        return float((self._posed_mesh() ^ other._posed_mesh()).volume())

    def _posed_mesh(self) -> Any:
        return self.body.mesh if self._home else self.body.mesh.transform(self.pose[:3])

    @cached_property
    def _home(self) -> bool:
        return bool(np.array_equal(self.pose, np.eye(4)))

    def _to_part(self, points: Floats) -> Floats:
        return points if self._home else transform_points(inverse(self.pose), points)


def iou(a: Solid, b: Solid) -> float:
    """Volume of the intersection over that of the union."""
    shared = a.shared_volume(b)
    return shared / (a.volume + b.volume - shared)


def clipped(body: Body, labels: Ints, surfaces: tuple[LabeledSurface, ...], keeper: Csg) -> Solid | None:
    """What of a body with (t,) labels lies in `keeper`, whose surfaces follow `surfaces`; None for nothing."""
    kept = body_within(body, labels, surfaces, keeper, TOLERANCE)
    return None if kept is None else Solid(kept, frozen(np.eye(4)))


def _thin(manifolds: list[Any]) -> Bools:
    """(n,) which of the pieces of one manifold are splinters."""
    boxes = [np.array(part.bounding_box()) for part in manifolds]
    return splinters([p.volume() for p in manifolds], [p.surface_area() for p in manifolds], boxes)


@njit(cache=True)
def _rays_to_part(origins, directions, world_from_part):  # type: ignore[no-untyped-def]
    n = len(origins)
    moved, turned = np.empty((n, 3), dtype=np.float32), np.empty((n, 3), dtype=np.float32)
    r, t = world_from_part[:3, :3], world_from_part[:3, 3]
    for i in range(n):
        x, y, z = origins[i, 0] - t[0], origins[i, 1] - t[1], origins[i, 2] - t[2]
        u, v, w = directions[i, 0], directions[i, 1], directions[i, 2]
        for k in range(3):
            moved[i, k] = x * r[0, k] + y * r[1, k] + z * r[2, k]
            turned[i, k] = u * r[0, k] + v * r[1, k] + w * r[2, k]
    return moved, turned
