"""Explore every convex built-in part at several poses, as `palpate explore` does, and hold it against the truth.

Asked: closed, right shapes, mean surface deviation at most 0.1 mm, every extent within 0.3 mm, at 5 % noise.
"""

import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from models import parts
from recognition.config import ExploreOptions
from recognition.explore import run as explore

POSES = int(os.environ.get("PALPATE_BENCH_POSES", "5"))
_TOUCHES = 150


def explore_once(name: str, seed: int, sensor: str = "lts210", noise: float | None = 0.05) -> dict[str, Any]:
    """One exploration and what came of it."""
    with tempfile.TemporaryDirectory() as folder:
        options = ExploreOptions(
            name, seed=seed, sensors=(sensor,), noise=noise, max_touches=_TOUCHES, out=Path(folder) / "run"
        )
        told: dict[str, Any] = explore(options, lambda _: None)
    truth = told["truth"]
    row = {
        "part": name,
        "seed": seed,
        "sensor": told["sensor"],
        "ended": told["ended"],
        "touches": told["touches"],
        "travel": told["travel_mm"],
        "device": told["device_seconds"],
        "wall": told["wall_seconds"],
        "good": False,
    }
    if truth["iou"] is None:
        return row
    worst = truth["extent_error_mm"]["max"]
    worst = float("inf") if worst is None else worst
    mean, shapes = truth["surface_mean_mm"], truth["face_shape_accuracy"]
    good = told["closed"] and shapes > 0.999 and mean <= 0.1 and worst <= 0.3
    return row | {
        "good": bool(good),
        "mean": mean,
        "extent": worst,
        "iou": truth["iou"],
        "shapes": shapes,
        "leaves": told["csg"]["leaves"],
    }


def run() -> list[dict[str, Any]]:
    """Rows for the table: per part, how many poses met every line, and the medians and worst."""
    rows: list[dict[str, Any]] = []
    for name in (n for n in parts.names() if parts.describe(n).convex):
        trials = []
        for seed in range(POSES):
            try:
                trials.append(explore_once(name, seed))
            except Exception as error:
                trials.append(
                    {"part": name, "seed": seed, "good": False, "ended": f"{type(error).__name__}: {error}"}
                )
            print({k: round(v, 4) if isinstance(v, float) else v for k, v in trials[-1].items()}, flush=True)
        rows.append(
            _row(name, "poses that met every line", sum(t["good"] for t in trials), f"of {POSES}", POSES)
        )
        for key, metric, unit, asked in (
            ("mean", "mean surface deviation, worst pose", "mm", 0.1),
            ("extent", "extent error, worst pose", "mm", 0.3),
            ("touches", "touches, median", "", None),
            ("wall", "wall time, median", "s", None),
        ):
            values = [t[key] for t in trials if key in t]
            if values:
                value = max(values) if "worst" in metric else float(np.median(values))
                rows.append(_row(name, metric, value, unit, asked))
    return rows


def _row(name: str, metric: str, value: float, unit: str, asked: float | None) -> dict[str, Any]:
    row = {"bench": "explore", "method": name, "metric": metric, "value": value, "unit": unit}
    return row if asked is None else row | {"asked": asked}
