"""How right an answer is, where its source is a run folder whose summary knows what stood there."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from models.library import Entry
from models.symmetry import pose_error
from primitives.pose import from_quaternion
from recognition.matching import Belief


def truth_of(source: str, belief: Belief, library: Mapping[str, Entry]) -> dict[str, Any] | None:
    """As `identify` tells it; None where the source knows no truth."""
    try:
        summary = json.loads((Path(source) / "summary.json").read_text())
        told = summary["truth"]["world_from_part"]
        name = summary["truth"].get("name") or summary["part"]
        world = from_quaternion(told["quaternion_wxyz"], told["translation_mm"])
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
    wanted = name if name in library else "unknown"
    best = belief.best(wanted) if belief.decision == wanted else None
    error = None if best is None else pose_error(library[wanted].symmetry, best.pose, world)
    return {
        "name": wanted,
        "correct": belief.decision == wanted,
        "translation_error_mm": None if error is None else error.distance,
        "rotation_error_deg": None if error is None else math.degrees(error.angle),
        "world_from_part": told,
    }
