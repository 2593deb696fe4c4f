"""A run's mesh with the faces that its contacts tell: of each smooth part, the face of most contacts on it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from models.part import load_part
from models.rays.triangle_tree import TriangleTree
from primitives.arrays import Floats, Ints
from recognition.report.drawn import drawn
from recognition.report.run_report import ReportMesh

_CREASE = np.cos(np.radians(15.0))  # of the angle between triangles of one smooth part


def labeled_mesh(path: Path, points: Floats, faces: Ints) -> ReportMesh | None:
    """The mesh of a file, labeled by (n, 3) contacts and the face of each; None where there is no file."""
    if not path.is_file():
        return None
    solid = load_part(path, units="mm").solid
    vertices, triangles = solid.vertices, solid.triangles
    smooth = smooth_parts(vertices, triangles)
    label = np.full(len(triangles), -1)
    told = faces >= 0
    if told.any():
        landed = smooth[TriangleTree(vertices, triangles).nearest(points[told]).triangle]
        for part in np.unique(landed):
            label[smooth == part] = np.bincount(faces[told][landed == part]).argmax()
    return drawn(solid, label)


def smooth_parts(vertices: Floats, triangles: Ints) -> Ints:
    """(t,) which smooth part of the surface each triangle belongs to."""
    count = len(triangles)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    normals = across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-12)
    sides = np.sort(
        np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1
    )
    order = np.lexsort((sides[:, 1], sides[:, 0]))
    owner, sides = order % count, sides[order]
    twins = np.flatnonzero((sides[1:] == sides[:-1]).all(axis=1))
    i, j = owner[twins], owner[twins + 1]
    flat = np.einsum("ij,ij->i", normals[i], normals[j]) > _CREASE
    joined = coo_matrix((np.ones(flat.sum()), (i[flat], j[flat])), shape=(count, count))
    parts: Ints = connected_components(joined, directed=False)[1].astype(np.int64)
    return parts
