"""A trial that explores, as the command does."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from primitives.errors import PalpateError
from recognition.config import ExploreOptions
from recognition.experiments.kinds.sensors import sensor_of
from recognition.experiments.settings import Value
from recognition.experiments.trial import Work
from recognition.explore import run
from recognition.running.summary import fault_of

_COST = ("touches", "strokes", "frames", "travel_mm", "device_seconds", "wall_seconds")
_TRUTH = ("iou", "hausdorff_mm", "surface_rms_mm", "surface_mean_mm", "face_shape_accuracy")


def carry(settings: Mapping[str, Value], work: Work) -> dict[str, Value]:
    """Explore, and say what came of it; a fault that ended exploration makes the trial one that failed."""
    s: Mapping[str, Any] = settings
    told: dict[str, Any] = {
        "part": work.file(s["part"]),
        "sensors": (sensor_of(s, work),),
        "pose_noise": s["pose_noise_mm"],
        "feature": s["feature_mm"],
        "max_touches": s["max_touches"],
        "seed": s["seed"],
        "out": work.scratch / "run",
    }
    told |= optional(ExploreOptions, {"policy": (s["policy"], "closure")})
    told |= optional(ExploreOptions, {"cover": (work.file(s["cover"]) if s["cover"] else "", "")})
    summary: dict[str, Any] = run(ExploreOptions(**told), lambda _: None)
    if fault := fault_of(summary):
        raise PalpateError(fault)
    truth = summary["truth"] or {}
    extents = truth.get("extent_error_mm") or {}
    return {
        "closed": summary["closed"],
        "ended": summary["ended"],
        **{key: summary[key] for key in _COST},
        "faces": len(summary["faces"]),
        "edges": len(summary["edges"]),
        "leaves": (summary["csg"] or {}).get("leaves"),
        **{key: truth.get(key) for key in _TRUTH},
        "extent_median_mm": extents.get("median"),
        "extent_max_mm": extents.get("max"),
    }


def optional(options: type[Any], told: Mapping[str, tuple[Any, Any]]) -> dict[str, Any]:
    """Settings, each with its default, that this version of a command may not take."""
    known = {field.name for field in fields(options)}
    for name, (value, default) in told.items():
        if name not in known and value != default:
            raise PalpateError(f"{name} = {value!r} is not to be had here; leave {name} out")
    return {name: value for name, (value, default) in told.items() if name in known and value != default}
