"""Triangles of the primitives with flat faces: exact, each labeled with the plane that it lies on."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from models.csg import Cube, Polyhedron, Prism
from models.leaves.polygons import triangulated
from primitives import shapes
from primitives.arrays import Floats, Ints, frozen

_MESH = 500  # planes of a polyhedron, from which it is a mesh
_ONE_PLANE = 1e-6  # [mm] between faces of a polyhedron that are on one plane, and between their unit normals


@dataclass(frozen=True)
class Facets:
    """A closed triangle mesh in the primitive's own frame."""

    vertices: Floats  # (v, 3) [mm]
    triangles: Ints  # (t, 3) wound so that normals point out
    surface: Ints  # (t,) index into `surfaces`
    surfaces: tuple[shapes.Shape | None, ...]  # outward; None where triangles stand for themselves


def cube_facets(cube: Cube) -> Facets:
    """Twelve triangles on six planes."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    triangles, planes = [], []
    for axis in range(3):
        for sign in (-1, 1):
            square = np.flatnonzero(corners[:, axis] == sign / 2)
            a, b, c, d = square if (sign > 0) == (axis != 1) else square[[0, 2, 1, 3]]
            triangles += [(a, c, d), (a, d, b)]
            normal = sign * np.eye(3)[axis]
            planes.append(shapes.Plane(normal * cube.size[axis] / 2, normal))
    return Facets(
        frozen(corners * cube.size),
        frozen(triangles, np.int64),
        frozen(np.repeat(np.arange(6), 2), np.int64),
        tuple(planes),
    )


def prism_facets(prism: Prism) -> Facets:
    """The two ends cut into triangles, and two triangles on each side."""
    outline, half = np.array(prism.outline), prism.height / 2
    n = len(outline)
    vertices = np.concatenate([np.column_stack([outline, np.full(n, z)]) for z in (-half, half)])
    ends, top = triangulated(outline), np.arange(n) + n
    low, after = np.arange(n), np.roll(np.arange(n), -1)
    triangles = np.concatenate(
        [
            ends[:, ::-1],
            ends + n,
            np.stack([low, after, after + n], axis=1),
            np.stack([low, after + n, top], axis=1),
        ]
    )
    along = np.roll(outline, -1, axis=0) - outline
    normals = np.column_stack([along[:, 1], -along[:, 0], np.zeros(n)])
    planes = [shapes.Plane(np.array([0.0, 0.0, s * half]), np.array([0.0, 0.0, float(s)])) for s in (-1, 1)]
    planes += [
        shapes.Plane(np.array([*p, 0.0]), m / np.linalg.norm(m))
        for p, m in zip(outline, normals, strict=True)
    ]
    labels = np.concatenate([np.zeros(n - 2), np.ones(n - 2), np.arange(n) + 2, np.arange(n) + 2])
    return Facets(frozen(vertices), frozen(triangles, np.int64), frozen(labels, np.int64), tuple(planes))


def polyhedron_facets(solid: Polyhedron) -> Facets:
    """Every face cut into triangles; one of very many planes is a mesh of what bends, and these are no faces."""
    points, (triangles, of_face) = np.array(solid.points), solid.triangles
    middles = np.stack([points[list(face)].mean(axis=0) for face in solid.faces])
    plane_of, first = _coplanar(middles, solid.normals)
    if len(first) > _MESH:
        return Facets(frozen(points), triangles, np.zeros(len(triangles), dtype=np.int64), (None,))
    planes = tuple(shapes.Plane(middles[f], solid.normals[f]) for f in first)
    return Facets(frozen(points), triangles, frozen(plane_of[of_face], np.int64), planes)


def _coplanar(points: Floats, normals: Floats) -> tuple[Ints, list[int]]:
    """(f,) plane of each of f faces, those on one plane numbered alike, and the first face of each plane."""
    plane = np.full(len(points), -1)
    first: list[int] = []
    alike = cKDTree(normals).query_ball_point(normals, _ONE_PLANE)  # a mesh may have thousands of faces
    for f in range(len(points)):
        if plane[f] < 0:
            near = np.array(alike[f])
            off = np.abs((points[near] - points[f]) @ normals[f])
            plane[near[(plane[near] < 0) & (off < _ONE_PLANE)]] = len(first)
            first.append(f)
    return plane, first
