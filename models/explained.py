"""How much of a solid's area its boundary explains: what is freeform, and what lies on no face's surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.boundary import BoundaryConfig, boundary, labeled_boundary
from models.solid import Solid


@dataclass(frozen=True)
class AstrayConfig:
    """When a triangle is not on the surface of the face that it was given to."""

    least: float = 0.1  # [mm] of a corner from the surface
    share: float = 2e-4  # of the part's size, the same


def freeform_area_fraction(solid: Solid, config: BoundaryConfig | None = None) -> float:
    """Area of freeform faces over that of all: what no plane, cylinder, cone, sphere or torus explains."""
    faces = boundary(solid, config).faces
    return sum(face.area for face in faces if face.shape is None) / sum(face.area for face in faces)


def unassigned_area_fraction(
    solid: Solid, config: BoundaryConfig | None = None, astray: AstrayConfig | None = None
) -> float:
    """Area of triangles with a corner astray from their face's surface, over that of all.

    A freeform face has no surface to be astray from; `freeform_area_fraction` says how much is such.
    """
    astray = astray or AstrayConfig()
    brep, face_of = labeled_boundary(solid, config)
    corners = solid.body.vertices[solid.body.triangles]
    area = solid.body.triangle_areas
    away = np.zeros(len(area))
    for face in brep.faces:
        if face.shape is not None:
            mine = face_of == face.id
            distance = np.abs(face.shape.signed_distance(corners[mine].reshape(-1, 3)))
            away[mine] = distance.reshape(-1, 3).max(axis=1)
    limit = max(astray.least, astray.share * float(np.ptp(solid.body.vertices, axis=0).max()))
    return float(area[away > limit].sum() / area.sum())
