"""Points on a solid that stand for its surface: spread evenly by area, exact normals and curvatures with them.

Every face has its share of the samples, and no fewer than `least`, however small it is; each sample knows the area
that it stands for.  Within a face they are systematic along the area, by the R2 sequence within triangles
(Roberts 2018).  Their order is shuffled, so the first k stand for the whole as well as k can.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.boundary import labeled_boundary
from models.brep import Brep
from models.solid import Solid
from primitives.arrays import Floats, Ints, frozen
from primitives.pose import transform_points

_R2 = np.array([0.7548776662466927, 0.5698402909980532])


@dataclass(frozen=True)
class SampleConfig:
    """How many."""

    count: int = 1024  # on the whole surface, about
    least: int = 3  # on a face


@dataclass(frozen=True, eq=False)
class SurfaceSamples:
    """n samples in the object's frame."""

    points: Floats  # (n, 3) [mm]
    normals: Floats  # (n, 3) unit, outward
    face: Ints  # (n,) id of the boundary's face
    area: Floats  # (n,) [mm^2] that each stands for
    curvatures: Floats  # (n, 2) principal, k1 >= k2 [1/mm], positive where convex; nan on freeform faces

    def __len__(self) -> int:
        return len(self.points)


def surface_samples(solid: Solid, config: SampleConfig | None = None) -> SurfaceSamples:
    """Samples of a solid, in the frame of its part; the same ones every time."""
    config = config or SampleConfig()
    brep, of_triangle = labeled_boundary(solid)
    body = solid.body
    corners = body.vertices[body.triangles]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    total = float(areas.sum())
    chosen, share = [], []
    for face in brep.faces:
        mine = np.flatnonzero(of_triangle == face.id)
        reached = np.cumsum(areas[mine])
        count = max(config.least, round(config.count * float(reached[-1]) / total))
        at = (np.arange(count) + 0.5) / count * reached[-1]
        chosen.append(mine[np.minimum(np.searchsorted(reached, at), len(mine) - 1)])
        share.append(np.full(count, reached[-1] / count))
    triangle = np.concatenate(chosen)
    order = np.random.default_rng(0).permutation(len(triangle))
    triangle, area = triangle[order], np.concatenate(share)[order]
    u, v = np.mod(np.arange(1, len(triangle) + 1)[:, None] * _R2, 1.0).T
    over = u + v > 1.0
    u, v = np.where(over, 1.0 - u, u), np.where(over, 1.0 - v, v)
    a, b, c = np.moveaxis(corners[triangle], 1, 0)
    points = a + u[:, None] * (b - a) + v[:, None] * (c - a)
    face_of = of_triangle[triangle]
    return _on_faces(brep, points, body.triangle_normals[triangle], face_of, area)


def _on_faces(brep: Brep, points: Floats, normals: Floats, face_of: Ints, area: Floats) -> SurfaceSamples:
    """Samples of facets, put on the exact surfaces that the facets stand for."""
    points, normals = points.copy(), normals.copy()
    curvatures = np.full((len(points), 2), np.nan)
    for face in brep.faces:
        if face.shape is None:
            continue
        mine, sign = face_of == face.id, 1.0 if face.convex else -1.0
        points[mine] = face.shape.project(points[mine])
        normals[mine] = sign * face.shape.normals(points[mine])
        bent = sign * face.shape.principal_curvatures(points[mine])
        curvatures[mine] = np.sort(bent, axis=1)[:, ::-1]
    return SurfaceSamples(
        frozen(points), frozen(normals), frozen(face_of, np.int64), frozen(area), frozen(curvatures)
    )


def moved(samples: SurfaceSamples, motion: Floats) -> SurfaceSamples:
    """The same samples after a (4, 4) rigid motion."""
    return SurfaceSamples(
        frozen(transform_points(motion, samples.points)),
        frozen(samples.normals @ motion[:3, :3].T),
        samples.face,
        samples.area,
        samples.curvatures,
    )
