"""Primitives under a stretch: the sizes that give the same solid, where there are such."""

from __future__ import annotations

import numpy as np

from models.csg import Cone, Csg, Cube, Cylinder, Polyhedron, Prism, Sphere, Torus
from models.formats.openscad.affine import SIX_DIGITS, Split
from models.formats.openscad.sided import outside
from primitives.arrays import Floats


def stretched(primitive: Csg, by: Floats, turned_over: bool) -> Csg | None:
    """A round primitive stretched along its axes; None where it loses its roundness."""
    x, y, z = (float(b) for b in by)
    if abs(x - y) > SIX_DIGITS * x:
        return None
    if isinstance(primitive, Cylinder):
        return Cylinder(primitive.radius * x, primitive.height * z, primitive.name)
    if isinstance(primitive, Cone):
        ends = (primitive.bottom_radius * x, primitive.top_radius * x)
        return Cone(*(ends[::-1] if turned_over else ends), primitive.height * z, primitive.name)
    if abs(x - z) > SIX_DIGITS * x:
        return None
    if isinstance(primitive, Sphere):
        return Sphere(primitive.radius * x, primitive.name)
    if isinstance(primitive, Torus):
        return Torus(primitive.major_radius * x, primitive.minor_radius * x, primitive.name)
    return None


def flat_sided(primitive: Cube | Prism | Polyhedron, matrix: Floats, parts: Split | None) -> Csg:
    """A primitive with flat faces under any matrix; it is a polyhedron where nothing simpler holds."""
    if parts is not None:
        x, y, z = parts.stretch.tolist()
        made: Csg | None = None
        if isinstance(primitive, Cube):
            made = Cube(tuple(np.abs(parts.stretch) * primitive.size), primitive.name)
        elif isinstance(primitive, Prism):
            outline = tuple((x * a, y * b) for a, b in primitive.outline)
            made = Prism(outline, abs(z) * primitive.height, primitive.name)
        else:
            moved = tuple((x * a, y * b, z * c) for a, b, c in primitive.points)
            made = Polyhedron(moved, primitive.faces, primitive.name)
        return made if np.array_equal(parts.rigid, np.eye(4)) else made.placed(parts.rigid)
    corners, faces = outside(primitive)
    corners = corners @ matrix[:3, :3].T + matrix[:3, 3]
    return Polyhedron(tuple(map(tuple, corners.tolist())), faces, primitive.name)
