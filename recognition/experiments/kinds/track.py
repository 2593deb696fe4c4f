"""A trial that tracks an edge or a surface, as the command does."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from recognition.experiments.kinds.sensors import sensor_of
from recognition.experiments.settings import Value
from recognition.experiments.trial import Work
from recognition.tracking.options import TrackOptions
from recognition.tracking.run import run
from recognition.tracking.view import View

_COST = ("touches", "strokes", "frames", "travel_mm", "device_seconds", "wall_seconds")


def carry(settings: Mapping[str, Value], work: Work) -> dict[str, Value]:
    """Track, and say how far from the truth."""
    s: Mapping[str, Any] = settings
    options = TrackOptions(
        part=work.file(s["part"]),
        sensors=(sensor_of(s, work),),
        pose_noise=s["pose_noise_mm"],
        seed=s["seed"],
        out=work.scratch / "run",
        what=s["what"],
        speed_mm_s=s["speed_mm_s"],
        latency_s=s["latency_s"],
    )
    summary = run(options, View())
    truth, force = summary["truth"] or {}, summary["force_n"]
    right = truth.get("shape") == summary["found"].get("shape") if s["what"] == "surface" else None
    return {
        "closed": summary["closed"],
        "lost": summary["lost"],
        **{key: summary[key] for key in _COST},
        "track_rms_mm": truth.get("rms_mm"),
        "track_max_mm": truth.get("max_mm"),
        "force_mean_n": force["mean"],
        "force_max_n": force["max"],
        "shape_right": right,
    }
