"""The five shapes that a face can have, and their parameters as files write them."""

from typing import Any

import numpy as np

from primitives.cone import Cone
from primitives.cylinder import Cylinder
from primitives.plane import Plane
from primitives.sphere import Sphere
from primitives.torus import Torus

__all__ = ["KINDS", "Cone", "Cylinder", "Plane", "Shape", "Sphere", "Torus", "parameters"]

Shape = Plane | Cylinder | Cone | Sphere | Torus

KINDS: dict[str, type[Shape]] = {
    "plane": Plane,
    "cylinder": Cylinder,
    "cone": Cone,
    "sphere": Sphere,
    "torus": Torus,
}


def parameters(shape: Shape) -> dict[str, Any]:
    """What the shape has and no more: origin_mm, axis, radius_mm, semi_angle_deg, minor_radius_mm."""
    out: dict[str, Any] = {"origin_mm": shape.anchor.tolist()}
    if not isinstance(shape, Sphere):
        out["axis"] = shape.direction.tolist()
    if isinstance(shape, Cylinder | Sphere | Torus):
        out["radius_mm"] = shape.radius
    if isinstance(shape, Cone):
        out["semi_angle_deg"] = float(np.rad2deg(shape.semi_angle))
    if isinstance(shape, Torus):
        out["minor_radius_mm"] = shape.minor_radius
    return out
