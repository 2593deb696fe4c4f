"""Explore the built-in parts that are not convex, one pose of each, and hold each model against the truth.

Each part is scaled by a factor between 0.9 and 1.1 that its seed draws, so that round numbers win nothing.  The
model is compared with the whole truth, and again with all that no array could come to filled in both.
`PALPATE_BENCH_PARTS=flange,bracket` explores some of them, `PALPATE_BENCH_SENSORS=lts210` with one array,
`PALPATE_BENCH_SEED` at another pose, `PALPATE_BENCH_POSE_NOISE=0` on a stage that does not err: each contact is
0.05 mm off else, and each reading 0.025 mm.
"""

import os
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from exploring.reachable import Reach, reach

from exploration.sensing.spec import load_sensor
from models import parts
from models.part import load_part
from models.solid import Solid
from primitives.arrays import Floats
from primitives.errors import PalpateError
from primitives.pose import from_quaternion
from recognition.config import ExploreOptions
from recognition.explore import run as explore

SEED = int(os.environ.get("PALPATE_BENCH_SEED", "1"))
SENSORS = tuple(os.environ.get("PALPATE_BENCH_SENSORS", "lts210,fingertip").split(","))
POSE_NOISE = float(os.environ.get("PALPATE_BENCH_POSE_NOISE", "0.05"))  # [mm]
_TOUCHES = 150
_METRICS = (  # metric, unit, asked
    ("iou of all", "", None),
    ("iou where an array could reach", "", 0.97),
    ("share of reachable area within 10 mm of what was felt", "", 0.95),
    ("mean surface deviation", "mm", 0.06),
    ("worst extent off", "mm", 0.2),
    ("share of face area of the right shape", "", 0.99),
    ("touches", "", None),
    ("device time", "s", None),
)


def run() -> list[dict[str, Any]]:
    """Rows per part, and the medians."""
    chosen = os.environ.get("PALPATE_BENCH_PARTS", "")
    names = chosen.split(",") if chosen else [n for n in parts.names() if not parts.describe(n).convex]
    found = []
    for k, name in enumerate(names):
        found.append(_explored(name))
        told = " ".join(f"{value:.4g}" for value in found[-1])
        print(f"concave: {k + 1} of {len(names)}, {name}: {told}", file=sys.stderr, flush=True)
    rows = [_row(name, *each) for name, told in zip(names, found, strict=True) for each in _each(told)]
    return [*rows, *(_row(f"median of {len(names)}", *each) for each in _each(np.nanmedian(found, axis=0)))]


def _explored(name: str) -> list[float]:
    """What `_METRICS` name of one exploration; nan where no closed body came of it."""
    scale = float(np.random.default_rng([SEED, *name.encode()]).uniform(0.9, 1.1))
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "run"
        options = ExploreOptions(
            name,
            seed=SEED,
            sensors=SENSORS,
            noise=0.05,
            pose_noise=POSE_NOISE,
            max_touches=_TOUCHES,
            scale=scale,
            out=out,
        )
        try:
            told: dict[str, Any] = explore(options, lambda _: None)
        except PalpateError as error:
            print(f"{name}: {error}", file=sys.stderr, flush=True)
            return [np.nan] * len(_METRICS)
        felt = np.loadtxt(out / "contacts.csv", delimiter=",", skiprows=1, usecols=(0, 1, 2), ndmin=2)
        reached = _reached(load_part(name, scale=scale).solid, told["truth"], out / "model.stl", felt)
    truth = told["truth"]
    values = (
        truth["iou"],
        None if reached is None else reached.iou,
        None if reached is None else reached.touched,
        truth.get("surface_mean_mm"),
        (truth.get("extent_error_mm") or {}).get("max"),
        truth.get("face_shape_accuracy"),
        told["touches"],
        told["device_seconds"],
    )
    return [np.nan if value is None else float(value) for value in values]


def _reached(part: Solid, truth: dict[str, Any], model: Path, felt: Floats) -> Reach | None:
    """The comparison with all filled that no array could come to; None without a model."""
    if truth["iou"] is None:
        return None
    where = truth["world_from_part"]
    placed = part.placed(from_quaternion(where["quaternion_wxyz"], where["translation_mm"]))
    housings = [load_sensor(sensor).housing for sensor in SENSORS]
    tools = [np.array([*h.size[:2], h.size[2] + h.proud]) for h in housings]
    return reach(load_part(model).solid, placed, tools, felt)


def _each(values: Any) -> list[tuple[str, float, str, float | None]]:
    return [
        (metric, float(value), unit, asked)
        for (metric, unit, asked), value in zip(_METRICS, values, strict=True)
    ]


def _row(name: str, metric: str, value: float, unit: str, asked: float | None) -> dict[str, Any]:
    row = {"bench": "concave", "method": name, "metric": metric, "value": value, "unit": unit}
    return row if asked is None else row | {"asked": asked}
