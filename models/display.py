"""A mesh light enough to draw: vertices that change the surface by less than a tolerance are dropped."""

import numpy as np

from models.body import Body
from models.solid import Solid
from primitives.arrays import Floats, Ints

_FIRST = 2e-4  # of the solid's size: the tolerance tried first
_INSIDE = np.array([[0.6, 0.2, 0.2], [0.2, 0.6, 0.2], [0.2, 0.2, 0.6]])  # where a triangle asks whose it is


def display_mesh(solid: Solid, face: Ints, most: int = 30_000) -> tuple[Floats, Ints, Ints]:
    """(v, 3) vertices, (t, 3) triangles, at most some `most` of them, and the (t,) face that each stands for.

    `face` is that of each triangle of the solid; all is in the part frame.
    """
    body = solid.body
    tolerance = _FIRST * float(np.ptp(body.vertices, axis=0).max())
    vertices, triangles = body.vertices, body.triangles
    for _ in range(10):
        if len(triangles) <= most:
            break
        mesh = body.mesh.simplify(tolerance).to_mesh64()
        vertices = np.asarray(mesh.vert_properties)[:, :3]
        triangles = np.asarray(mesh.tri_verts).astype(np.int64)
        tolerance *= 2
    if triangles is body.triangles:
        return vertices, triangles, face
    return vertices, triangles, faces_of(body, face, vertices, triangles)


def faces_of(body: Body, face: Ints, vertices: Floats, triangles: Ints) -> Ints:
    """(t,) the face behind each triangle of a coarser mesh, given that of each of the body's own."""
    asked = np.einsum("ki,tix->ktx", _INSIDE, vertices[triangles])
    first, second, third = (face[body.tree.nearest(points).triangle] for points in asked)
    return np.where(second == third, second, first)
