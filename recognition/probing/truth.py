"""The evaluator of probes: what the object is made of where it was touched, and how far contacts are from it."""

from __future__ import annotations

from math import isfinite
from typing import Any

import numpy as np

from models.material import MadeOf
from primitives.evidence import Contacts
from recognition.tracking.truth import surface_truth


def probe_truth(made: MadeOf, contacts: Contacts) -> dict[str, Any] | None:
    """Of the face that most contacts lie on; None without contacts."""
    if not len(contacts):
        return None
    face = int(np.bincount(made.faces_at(contacts.points)).argmax())
    material = made.material_of(face)
    return {
        **(surface_truth(made.solid, contacts) or {}),
        "face": face,
        "stiffness_n_mm3": material.stiffness if isfinite(material.stiffness) else None,
        "roughness_mm": material.roughness,
        "temperature_c": made.temperature,
    }
