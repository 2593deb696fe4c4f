"""Which exact surface every triangle of a closed mesh stands for.

The steps: triangles in one plane become facets (`flats`), facets that meet become a graph (`creases`), and what
is left over is a plane each.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.body import LabeledSurface
from models.recovery.creases import find_creases
from models.recovery.flats import find_flats
from primitives.arrays import Floats, Ints, frozen
from primitives.shapes import Plane


@dataclass(frozen=True)
class RecoveryOptions:
    """Tolerances; lengths are in units of the diagonal of the mesh's box."""

    flat: float = 2e-5  # from its plane that a corner of a facet may be
    flat_deg: float = 0.5  # [deg] between the normals of triangles of one facet


@dataclass(frozen=True)
class Recovered:
    """Surfaces behind the triangles of a mesh."""

    face_of_triangle: Ints  # (t,) index into `surfaces`
    surfaces: tuple[LabeledSurface, ...]  # with no shape where the triangles are freeform


def recover(
    vertices: Floats, triangles: Ints, neighbors: Ints, options: RecoveryOptions | None = None
) -> Recovered:
    """The surfaces of a closed mesh of (v, 3) vertices [mm] and (t, 3) triangles with (t, 3) neighbors."""
    tolerances = options or RecoveryOptions()
    diagonal = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    flats = find_flats(
        vertices, triangles, neighbors, tolerances.flat * diagonal, np.deg2rad(tolerances.flat_deg)
    )
    find_creases(vertices, triangles, neighbors, flats)
    surfaces = tuple(
        LabeledSurface(Plane(center, normal), True, -1)
        for center, normal in zip(flats.center, flats.normal, strict=True)
    )
    return Recovered(frozen(flats.of_triangle, np.int64), surfaces)
