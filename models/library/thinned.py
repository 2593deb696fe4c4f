"""A solid's mesh with fewer triangles, never farther from it than a small share of its size.

A solid that knows its tree is meshed again with larger facets, which touch the exact surfaces at their corners;
any other one loses vertices.  Where that is not enough the record becomes larger, not wrong.
"""

from __future__ import annotations

import numpy as np

from models.display import faces_of
from models.solid import Solid
from primitives.arrays import Floats, Ints

_FINEST, _COARSEST = 2e-4, 1e-3  # of the largest side: tolerances that are tried, each twice the last


def thinned(solid: Solid, face: Ints, most: int) -> tuple[Floats, Ints, Ints]:
    """(v, 3) vertices, (t, 3) triangles, if possible at most some `most`, and the (t,) face behind each."""
    body = solid.body
    vertices, triangles = body.vertices, body.triangles
    largest = float(np.ptp(vertices, axis=0).max())
    tolerance = _FINEST * largest
    while len(triangles) > most and tolerance <= _COARSEST * largest:
        if solid.csg is None:
            mesh = body.mesh.simplify(tolerance).to_mesh64()
            vertices = np.asarray(mesh.vert_properties)[:, :3]
            triangles = np.asarray(mesh.tri_verts).astype(np.int64)
        else:
            again = Solid.from_csg(solid.csg, tolerance).body
            vertices, triangles = again.vertices, again.triangles
        tolerance *= 2
    if triangles is body.triangles:
        return vertices, triangles, face
    return vertices, triangles, faces_of(body, face, vertices, triangles)
