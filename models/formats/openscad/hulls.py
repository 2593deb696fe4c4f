"""Convex hulls of points: corners in the plane, faces in space, flat ones whole."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from models.leaves.polygons import cleaned
from primitives.arrays import Floats
from primitives.errors import PalpateError
from primitives.pose import frame_along


def convex_corners(points: Floats) -> Floats:
    """(m, 2) corners of the convex hull, counterclockwise."""
    try:
        return cleaned(points[ConvexHull(points).vertices])
    except QhullError:
        raise PalpateError("these points lie on one line; spread them out") from None


def convex_faces(points: Floats) -> list[list[int]]:
    """Indices of (n, 3) points round each face of their convex hull; triangles in one plane are one face."""
    try:
        hull = ConvexHull(points)
    except QhullError:
        raise PalpateError("these corners lie in one plane; give the solid a height") from None
    planes = np.round(hull.equations / [1, 1, 1, np.ptp(points, axis=0).max()], 7)
    faces = []
    for plane in np.unique(planes, axis=0):
        of_face = np.unique(hull.simplices[(planes == plane).all(axis=1)])
        flat = (points[of_face] - points[of_face].mean(axis=0)) @ frame_along(plane[:3])[:, :2]
        faces.append(of_face[np.argsort(np.arctan2(flat[:, 1], flat[:, 0]))].tolist())
    return faces
