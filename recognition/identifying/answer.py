"""What an identification says: candidates, why it is the first and not the second, and how true that is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from models.library import Library
from models.solid import Solid
from models.symmetry import pose_error
from primitives.arrays import Floats
from primitives.pose import quaternion_wxyz
from recognition.matching import Belief
from recognition.matching.next_touch.choose import Choice
from recognition.matching.next_touch.held import UNKNOWN

_LEAST = 5e-4  # probability of a candidate that is listed


def candidates_json(belief: Belief, library: Library, most: int = 10) -> list[dict[str, Any]]:
    """The likeliest names, each with its likeliest pose; `unknown` has none."""
    ranked = sorted(belief.probabilities.items(), key=lambda item: -item[1])[:most]
    return [
        _candidate(name, float(p), belief, library)
        for k, (name, p) in enumerate(ranked)
        if p > _LEAST or not k
    ]


def _candidate(name: str, probability: float, belief: Belief, library: Library) -> dict[str, Any]:
    best = None if name == UNKNOWN else belief.best(name)
    if best is None:
        return {"name": name, "probability": probability, "pose": None, "pose_sigma": None, "symmetry": None,
                "residual_mm": None}  # fmt: skip
    return {
        "name": name,
        "probability": probability,
        "pose": pose_json(best.pose),
        "pose_sigma": {
            "translation_mm": best.translation_sigma,
            "rotation_deg": float(np.degrees(best.rotation_sigma)),
        },
        "symmetry": library[name].symmetry.name,
        "residual_mm": best.residual,
    }


def pose_json(pose: Floats) -> dict[str, Any]:
    """As the summary writes poses."""
    return {"translation_mm": pose[:3, 3].tolist(), "quaternion_wxyz": quaternion_wxyz(pose).tolist()}


def why_json(belief: Belief, separate: Choice | None) -> dict[str, Any]:
    """The runner-up, the contacts that speak against it, and the touch that would settle what is left."""
    ranked = sorted(belief.probabilities, key=lambda name: -belief.probabilities[name])
    second = ranked[1] if len(ranked) > 1 else None
    told: dict[str, Any] = {"runner_up": second, "separating_contacts": []}
    if second is not None and UNKNOWN not in ranked[:2]:
        told["separating_contacts"] = list(belief.separating(ranked[0], second))
    if separate is not None:
        told["separating_touch"] = {
            "start": pose_json(separate.approach.start),
            "direction": separate.approach.direction.tolist(),
            "length_mm": separate.approach.length,
            "bits": separate.name_bits,
            "seconds": separate.seconds,
        }
    return told


def truth_json(belief: Belief | None, library: Library, name: str, solid: Solid) -> dict[str, Any]:
    """Whether the decision is right, and how far the pose is off, up to symmetry."""
    wanted = name if name in library else UNKNOWN
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
