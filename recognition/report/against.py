"""The object itself as a page draws it, and how far a model is from it."""

from __future__ import annotations

from models.part import Part
from models.solid import Solid
from recognition.report.deviation import deviation
from recognition.report.drawn import drawn
from recognition.report.run_report import Deviation, ReportMesh
from recognition.truth import LabeledFaces

_DRAWN_FACET = 0.02  # [mm] between a drawn facet and the surface that it stands for


def drawn_truth(part: Part, solid: Solid) -> ReportMesh:
    """The part at its pose, in facets as coarse as a drawing allows where it was made from a tree."""
    if part.csg is not None:
        solid = Solid.from_csg(part.csg, _DRAWN_FACET).placed(solid.pose)
    return drawn(solid, LabeledFaces.of(solid).of_triangle)


def off_truth(model: ReportMesh | None, solid: Solid) -> Deviation | None:
    """The model's distance from the part at its pose; None where there is no model."""
    return None if model is None or not len(model.triangles) else deviation(model, solid)
