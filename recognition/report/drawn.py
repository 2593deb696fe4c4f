"""A solid as a page draws it: in no more triangles than a page holds."""

from __future__ import annotations

import numpy as np

from models.display import display_mesh
from models.solid import Solid
from primitives.arrays import Ints
from primitives.pose import transform_points
from recognition.report.payload import PayloadLimits
from recognition.report.run_report import ReportMesh


def drawn(solid: Solid, of_triangle: Ints) -> ReportMesh:
    """Its mesh in the world, made coarser where it is too fine, with the (t,) face of each of its triangles."""
    vertices, triangles, face = display_mesh(solid, of_triangle, PayloadLimits().triangles)
    return ReportMesh(transform_points(solid.pose, vertices), np.asarray(triangles, dtype=np.int64), face)
