"""Explore every convex built-in part at several poses, and hold the result against the truth.

Asked: closed, right shapes, mean surface deviation at most 0.1 mm, every extent within 0.3 mm, at 5 % noise.
"""

import os
import time
from typing import Any

import numpy as np

from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.planning.explorer import Explorer, ExplorerConfig
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models import parts
from models.solid import Solid
from primitives import pose as se3
from primitives.fit import Fit
from recognition.assembly.assemble import assemble
from recognition.truth import evaluate

POSES = int(os.environ.get("PALPATE_BENCH_POSES", "5"))
BOX = np.array([-300.0, -300.0, -300.0, 300.0, 300.0, 300.0])


def explore_once(name: str, seed: int) -> dict[str, Any]:
    """One exploration and what came of it."""
    rng = np.random.default_rng(seed)
    world_from_part = se3.pose(se3.random_rotation(rng), rng.uniform(-35.0, 35.0, 3))
    truth = Solid.from_csg(parts.build(name)).placed(world_from_part)
    above = se3.pose(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, 300.0])
    stage, arrays = simulate(truth, [load_sensor("lts210")], rng, noise=0.05, start_pose=above)
    guard = Guard(stage, arrays, [Calibration.nominal(arrays[0].spec)])
    explorer = Explorer(guard, BOX, ExplorerConfig(max_touches=150))
    began = time.perf_counter()
    for _ in explorer.run():
        pass
    wall = time.perf_counter() - began
    faces = [face for face in explorer.found.graph.faces if isinstance(face.fit, Fit)]
    row: dict[str, Any] = {
        "part": name,
        "seed": seed,
        "ended": explorer.found.ended,
        "touches": guard.cost.touches,
        "travel": guard.cost.travel,
        "device": guard.cost.seconds,
        "wall": wall,
        "good": False,
    }
    built = assemble(faces, BOX.reshape(2, 3))  # type: ignore[arg-type]
    if not built:
        return row | {"note": f"not closed: {built.reason[:60]}"}
    found = evaluate(built.solid, truth)
    worst = max(found.extent_errors, default=float("inf"))
    good = (
        row["ended"] == "closed"
        and found.face_shape_accuracy > 0.999
        and found.surface_mean <= 0.1
        and worst <= 0.3
    )
    return row | {
        "good": good,
        "mean": found.surface_mean,
        "extent": worst,
        "iou": found.iou,
        "shapes": found.face_shape_accuracy,
        "leaves": len(list(built.tree.leaves())),
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
