"""The hull of balls of one size, which is also the Minkowski sum of a convex solid and a ball.

With P the hull of the centers, P + ball(r) is the union of P, of a slab of thickness 2 r about each of its faces,
of a bar round each of its edges and of a ball at each of its corners: the slab's inner half is no farther than r
from P (our derivation).
"""

from __future__ import annotations

from functools import reduce

import numpy as np

from models.csg import Csg, Cylinder, Polyhedron, Prism, Sphere
from models.formats.openscad.hulls import convex_corners, convex_faces
from primitives.arrays import Floats
from primitives.pose import frame_along, pose

_FLAT = 1e-7  # of the spread of the centers: flatter is a plane or a line


def hull_of_balls(centers: Floats, radius: float) -> Csg:
    """The hull of balls round (n, 3) centers."""
    middle = centers.mean(axis=0)
    _, spread, axes = np.linalg.svd(centers - middle, full_matrices=False)
    rank = int((spread > _FLAT * max(spread[0], radius)).sum())
    if rank == 0:
        return Sphere(radius).placed(pose(None, middle))
    if rank == 1:
        along = (centers - middle) @ axes[0]
        return _round([centers[[int(np.argmin(along)), int(np.argmax(along))]]], radius)
    if rank == 2:
        plane = frame_along(np.cross(axes[0], axes[1]))
        flat = convex_corners((centers - middle) @ plane[:, :2])
        ring = middle + flat @ plane[:, :2].T
        return _slab(ring, plane[:, 2], radius) | _round([ring], radius)
    faces = convex_faces(centers)
    core = Polyhedron(tuple(map(tuple, centers.tolist())), tuple(map(tuple, faces)))
    corners = np.array(core.points)
    tree: Csg = core
    slabs = [_slab(corners[list(f)], n, radius) for f, n in zip(core.faces, core.normals, strict=True)]
    return reduce(lambda a, b: a | b, slabs, tree) | _round(
        [corners[list(face)] for face in core.faces], radius
    )


def _slab(ring: Floats, normal: Floats, radius: float) -> Csg:
    turn = frame_along(normal)
    middle = ring.mean(axis=0)
    outline = tuple(map(tuple, ((ring - middle) @ turn[:, :2]).tolist()))
    return Prism(outline, 2 * radius).placed(pose(turn, middle))


def _round(rings: list[Floats], radius: float) -> Csg:
    """Bars round all sides and balls at all corners of (n, 3) rings, each once."""
    parts: list[Csg] = []
    seen: set[tuple[float, ...]] = set()
    for ring in rings:
        for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            middle, length = (a + b) / 2, float(np.linalg.norm(b - a))
            if tuple(middle) not in seen:
                seen.add(tuple(middle))
                parts.append(Cylinder(radius, length).placed(pose(frame_along((b - a) / length), middle)))
            if tuple(a) not in seen:
                seen.add(tuple(a))
                parts.append(Sphere(radius).placed(pose(None, a)))
    return reduce(lambda a, b: a | b, parts)
