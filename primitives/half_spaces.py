"""The body on the inner side of every one of some fitted surfaces; a first guess of a convex part.

The body is {x : max_i s_i d_i(x) <= 0} with d_i the signed distance of surface i and s_i = +1 where the
material is inside it, -1 where it is outside (a hole).  Each d_i is 1-Lipschitz, so the maximum is exact
inside a convex body and a lower bound of the distance outside any.  It is defined by one surface as well as
by all, so it serves while exploration goes on: what is not yet touched is open as far as the given box.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from primitives.arrays import Bools, Floats, Ints, frozen
from primitives.charts import chart, sample_chart
from primitives.shapes import Shape
from primitives.surface import RayHits

_ON = 1e-6  # [mm] a hit within this of another surface still belongs to the body


@dataclass(frozen=True)
class BoundarySamples:
    """Points spread over a boundary."""

    points: Floats  # (n, 3) [mm]
    normals: Floats  # (n, 3) outward
    face: Ints  # (n,) index of the surface
    area: Floats  # (n,) [mm^2] that each stands for


@dataclass(frozen=True)
class HalfSpaces:
    """Where all of `shapes` are satisfied; implements the `Surface` protocol."""

    shapes: tuple[Shape, ...]
    convex: tuple[bool, ...]  # whether the material is inside each

    @staticmethod
    def of(shapes: Sequence[Shape], convex: Sequence[bool] | None = None) -> HalfSpaces:
        """With every surface convex unless told otherwise."""
        return HalfSpaces(tuple(shapes), tuple(convex) if convex is not None else (True,) * len(shapes))

    def distances(self, points: Floats) -> Floats:
        """(n, m) signed distance [mm] of each point to each surface, negative on the material's side."""
        out = np.empty((len(points), len(self.shapes)))
        for i, (shape, convex) in enumerate(zip(self.shapes, self.convex, strict=True)):
            distance = shape.signed_distance(points)
            out[:, i] = distance if convex else -distance
        return out

    def signed_distance(self, points: Floats) -> Floats:
        """(n,) [mm] the greatest of the distances; -inf where there is no surface at all."""
        return np.asarray(self.distances(points).max(axis=1, initial=-np.inf))

    def contains(self, points: Floats, margin: float = 0.0) -> Bools:
        """(n,) whether points lie at least `margin` [mm] inside every surface."""
        return np.asarray(self.signed_distance(points) <= -margin)

    def normals(self, points: Floats) -> Floats:
        """(n, 3) outward unit normal of the surface that binds most at each point."""
        binding = self.distances(points).argmax(axis=1)
        out = np.empty((len(points), 3))
        for i in np.unique(binding):
            rows = binding == i
            out[rows] = self._normals_of(int(i), points[rows])
        return out

    def cast_rays(self, origins: Floats, directions: Floats) -> RayHits:
        """First hits from outside; a hit of one surface counts where all the others are satisfied."""
        best = np.full(len(origins), np.inf)
        element = np.full(len(origins), -1)
        for i, shape in enumerate(self.shapes):
            start = (origins - shape.anchor) @ shape.frame
            along = directions @ shape.frame
            nearest = -(start * along).sum(axis=1)  # solve from beside the anchor: far rays stay exact
            travel = shape.roots(start + nearest[:, None] * along, along) + nearest[:, None]
            ray, root = np.nonzero(np.isfinite(travel) & (travel >= 0.0))
            t = travel[ray, root]
            at = origins[ray] + t[:, None] * directions[ray]
            others = self.distances(at)
            others[:, i] = -np.inf
            entering = (self._normals_of(i, at) * directions[ray]).sum(axis=1) < 0
            counts = entering & (others.max(axis=1) <= _ON)
            allowed = np.full(travel.shape, np.inf)
            allowed[ray[counts], root[counts]] = t[counts]
            first = allowed.min(axis=1, initial=np.inf)
            closer = first < best
            best[closer], element[closer] = first[closer], i
        normals = np.zeros((len(origins), 3))
        for i in range(len(self.shapes)):
            rows = element == i
            if rows.any():
                normals[rows] = self._normals_of(i, origins[rows] + best[rows, None] * directions[rows])
        return RayHits(best, normals, element)

    def sample_boundary(self, box: Floats, spacing: float) -> BoundarySamples:
        """Points at most `spacing` [mm] apart on the body's own surfaces, within the (2, 3) `box` [mm].

        The box cuts but is no boundary: where the body is open, there are no samples on the box's walls.
        """
        low, high = np.asarray(box, dtype=float)
        points, normals, face, area = [np.empty((0, 3))], [np.empty((0, 3))], [np.empty(0)], [np.empty(0)]
        for i, shape in enumerate(self.shapes):

            def bound(at: Floats, own: int = i) -> Floats:
                distances = self.distances(at)
                distances[:, own] = np.maximum(low - at, at - high).max(axis=1)
                return np.asarray(distances.max(axis=1))

            cells = sample_chart(chart(shape, box), spacing, bound)
            points.append(cells.points)
            normals.append(self._normals_of(i, cells.points))
            face.append(np.full(len(cells.points), i))
            area.append(cells.area)
        return BoundarySamples(
            frozen(np.concatenate(points)),
            frozen(np.concatenate(normals)),
            frozen(np.concatenate(face), np.int64),
            frozen(np.concatenate(area)),
        )

    def _normals_of(self, index: int, points: Floats) -> Floats:
        normals = self.shapes[index].normals(points)
        return normals if self.convex[index] else -normals
