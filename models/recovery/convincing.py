"""Whether a few facets are chords of something round, and not the sides of a prism."""

from __future__ import annotations

import numpy as np

from models.recovery.curved_options import CurvedOptions
from models.recovery.fits import depth
from models.recovery.grow import Mesh
from primitives.arrays import Floats, Ints
from primitives.shapes import Shape


def convincing(
    kind: str, mesh: Mesh, shape: Shape, convex: bool, members: Ints, turn: float, options: CurvedOptions
) -> bool:
    """Whether facets are enough to call them round and not a prism: many, tangent to a neighbor, or regular."""
    thick = members[~mesh.thin[members]]
    if len(thick) < options.fewest[kind]:
        return False
    if len(thick) > options.few:
        return True
    if _touches_smoothly(mesh, shape, convex, thick, options):
        return True
    widths = np.sqrt(depth(mesh, shape, thick))
    if widths.max() > options.regular * widths.min():
        return False
    return len(thick) > 3 or turn < options.gentle


def _touches_smoothly(mesh: Mesh, shape: Shape, convex: bool, members: Ints, options: CurvedOptions) -> bool:
    """Whether some neighbor is tangent to the surface where it meets the members."""
    creases, start = mesh.creases, mesh.flats.start
    inside = set(members.tolist())
    for f in members.tolist():
        mine = mesh.flats.corners[start[f] : start[f + 1]]
        for i in range(*creases.around(f).indices(len(creases.other))):
            g = int(creases.other[i])
            if g in inside or abs(creases.turn[i]) > options.smooth or mesh.thin[g]:
                continue
            shared = np.intersect1d(mine, mesh.flats.corners[start[g] : start[g + 1]])
            normals: Floats = shape.normals(mesh.vertices[shared]) * (1.0 if convex else -1.0)
            if len(shared) and (normals @ mesh.flats.normal[g] > np.cos(options.tangent)).all():
                return True
    return False
