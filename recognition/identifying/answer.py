"""What an identification says: how true it is, and the answer in a line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from models.library import Library
from models.solid import Solid
from models.symmetry import pose_error
from recognition.identifying.placed import PlacedConfig
from recognition.matching import Belief
from recognition.matching.belief import UNKNOWN
from recognition.recognizing.answer import pose_json
from recognition.recognizing.truth import right_name


def truth_json(belief: Belief | None, library: Library, name: str, solid: Solid) -> dict[str, Any]:
    """Whether the decision is right, and how far the pose is off, up to symmetry."""
    wanted = right_name(name, solid.extent, library)
    decision = None if belief is None else belief.decision
    told: dict[str, Any] = {
        "name": wanted,
        "correct": decision == wanted,
        "translation_error_mm": None,
        "rotation_error_deg": None,
        "world_from_part": pose_json(solid.pose),
    }
    best = None if belief is None or decision != wanted else belief.best(wanted)
    if best is not None:
        error = pose_error(library[wanted].symmetry, best.pose, solid.pose)
        told["translation_error_mm"] = error.distance
        told["rotation_error_deg"] = float(np.degrees(error.angle))
    return told


def of_pose(
    ended: str, candidates: Sequence[Mapping[str, Any]], config: PlacedConfig | None = None
) -> list[str]:
    """A warning where it is sure which object it is, and its pose is not known as well as that usually is."""
    config = config or PlacedConfig()
    sigma = candidates[0]["pose_sigma"] if candidates else None
    if ended != "sure" or sigma is None:
        return []
    place, turn = sigma["translation_mm"], sigma["rotation_deg"]
    if place <= config.sigma and turn <= np.degrees(config.turned):
        return []
    return [
        f"the name is sure, its pose only to {place:.2g} mm and {turn:.2g} degrees (1 sigma): "
        "the touches after that told no more of it"
    ]


def of_search(ended: str, met: Sequence[bool]) -> list[str]:
    """A warning where most of the touches, of which each met something or not, went by before one did."""
    empty = list(met).index(True) if any(met) else len(met)
    if ended == "sure" or 2 * empty <= len(met):
        return []
    return [
        f"{empty} of {len(met)} touches met nothing, before anything was found: "
        "give a smaller --workspace, or raise --max-touches"
    ]


def reason_in_words(summary: Mapping[str, Any]) -> str:
    """The answer in one line."""
    decision, share = summary["decision"], summary["confidence"]
    if not summary["met"]:
        return f"nothing was met; {decision} leads with the {share:.1%} that it had before"
    if decision == UNKNOWN:
        return f"none of the library's {summary['library']['objects']} objects, {share:.1%} sure"
    return f"it is {decision}, {share:.1%} sure"


def top(probabilities: Mapping[str, float], count: int = 3) -> list[list[Any]]:
    """The likeliest names with their probabilities."""
    ranked = sorted(probabilities.items(), key=lambda item: -item[1])[:count]
    return [[name, float(p)] for name, p in ranked]
