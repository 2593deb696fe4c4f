"""How right an answer is, where its source is a run folder whose summary knows what stood there.

A name alone does not say what that was: made larger or smaller, or read in another unit, it is another object.
"""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from models.library import Entry
from models.symmetry import pose_error
from primitives.arrays import Floats
from primitives.pose import from_quaternion
from recognition.matching import Belief
from recognition.matching.belief import UNKNOWN

_ALIKE = 0.01  # of each side of its box: meshes of one object differ by as much


def right_name(name: str, extent: Floats | None, library: Mapping[str, Entry]) -> str:
    """What an object of a (3,) `extent` [mm] is to a library; None: nobody told its size."""
    if name not in library:
        return UNKNOWN
    if extent is None:
        return name
    own, other = np.sort(library[name].solid.extent), np.sort(extent)
    return name if np.allclose(own, other, rtol=_ALIKE, atol=0.0) else UNKNOWN


def truth_of(
    source: str, belief: Belief, library: Mapping[str, Entry], scale: float = 1.0
) -> dict[str, Any] | None:
    """As `identify` tells it, of a library made larger by `scale`; None where the source knows no truth."""
    try:
        summary = json.loads((Path(source) / "summary.json").read_text())
        told = summary["truth"]["world_from_part"]
        name = summary.get("part") or summary["truth"]["name"]  # the truth's may be that of another library
        world = from_quaternion(told["quaternion_wxyz"], told["translation_mm"])
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
    wanted = _right_name(name, Path(source) / "config.toml", library, scale)
    best = belief.best(wanted) if belief.decision == wanted else None
    error = None if best is None else pose_error(library[wanted].symmetry, best.pose, world)
    return {
        "name": wanted,
        "correct": belief.decision == wanted,
        "translation_error_mm": None if error is None else error.distance,
        "rotation_error_deg": None if error is None else math.degrees(error.angle),
        "world_from_part": told,
    }


def _right_name(name: str, config: Path, library: Mapping[str, Entry], scale: float) -> str:
    """As the run's settings tell the size; before they did, its scale says whether the library's is another."""
    try:
        told = tomllib.loads(config.read_text(encoding="utf-8"))
        extent = told.get("resolved", {}).get("part_extent_mm")
        other = float(told.get("settings", {}).get("scale", scale)) != scale
        size = None if extent is None else np.array(extent, dtype=float).reshape(3)
    except (OSError, ValueError, TypeError, AttributeError):
        return right_name(name, None, library)
    return UNKNOWN if size is None and other else right_name(name, size, library)
