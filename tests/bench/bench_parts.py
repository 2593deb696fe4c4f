"""Explore parts, one pose of each, on a stage that errs as the trackers' does, and hold models against the truth.

All built-in parts, or those and the CAD files that `PALPATE_BENCH_PARTS=flange,some/file.step` names, or one of
the bodies in a file, `assembly.step#3`; `part.stl@m` is one in meters.  The seed draws each part's size, so that
round numbers win nothing: built-in ones are scaled by 0.9 to 1.1, files to 60 to 160 mm.  `PALPATE_BENCH_SEED`
takes another pose and size, `PALPATE_BENCH_SENSORS=lts210` one array, `PALPATE_BENCH_POSE_NOISE=0` a stage that
does not err, `PALPATE_BENCH_WORKERS=2` as many parts at once.
`PALPATE_BENCH_REACH=1` compares again with all that no array could come to filled in both, half a minute a part,
and `PALPATE_BENCH_KEEP=FOLDER` keeps the runs, and what was told of each in `FOLDER/told.jsonl`.
"""

import json
import os
import sys
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import ExitStack
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from exploring.trial import Trial, explored

from models import parts

SEED = int(os.environ.get("PALPATE_BENCH_SEED", "1"))
SENSORS = tuple(os.environ.get("PALPATE_BENCH_SENSORS", "lts210,fingertip").split(","))
ERRING = os.environ.get("PALPATE_BENCH_POSE_NOISE", "") != "0"
REACH = os.environ.get("PALPATE_BENCH_REACH", "") == "1"
WORKERS = int(os.environ.get("PALPATE_BENCH_WORKERS", "1"))
KEEP = os.environ.get("PALPATE_BENCH_KEEP", "")

_ONE_CORE = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
_METRICS = (  # metric, where a run tells it, unit, asked of a built-in part, asked of a file
    ("iou", "truth.iou", "", None, 0.97),  # of a built-in part so much as a skin 0.05 mm thick leaves
    ("iou where an array could reach", "reach.iou", "", None, None),
    ("share of reachable area within 10 mm of what was felt", "reach.touched", "", 0.95, 0.95),
    ("surface off in the mean", "truth.surface_mean_mm", "mm", 0.06, None),
    ("worst extent off", "truth.extent_error_mm.max", "mm", 0.2, None),
    ("share of face area of the right shape", "truth.face_shape_accuracy", "", 0.99, 0.95),
    ("touches", "touches", "", None, None),
    ("device time", "device_seconds", "s", None, None),
    ("computing", "wall_seconds", "s", None, None),
)


def run() -> list[dict[str, Any]]:
    """Rows for each part, the medians, and how many parts came up to what is asked."""
    chosen = os.environ.get("PALPATE_BENCH_PARTS", "")
    names = chosen.split(",") if chosen else list(parts.names())
    told: dict[str, dict[str, Any]] = {}
    with ExitStack() as stack:
        folder = Path(KEEP) if KEEP else Path(stack.enter_context(tempfile.TemporaryDirectory()))
        folder.mkdir(parents=True, exist_ok=True)
        log = stack.enter_context((folder / "told.jsonl").open("a"))
        trials = [Trial(name, SEED, SENSORS, folder / Path(name).name, ERRING, REACH) for name in names]
        for trial, found in _all(trials):
            told[trial.part] = found
            log.write(json.dumps({"name": trial.part, "seed": trial.seed} | found) + "\n")
            log.flush()
            print(
                f"parts: {len(told)} of {len(names)}, {_line(trial.part, found)}", file=sys.stderr, flush=True
            )
    rows = [row for name in names for row in _rows(name, told[name])]
    return [*rows, *_summed(told)]


def _all(trials: Sequence[Trial]) -> Iterator[tuple[Trial, dict[str, Any]]]:
    """Each with what came of it, as they end; a worker that dies takes only its own with it."""
    if WORKERS == 1:
        yield from ((trial, explored(trial)) for trial in trials)
        return
    os.environ |= _ONE_CORE  # before workers begin: libraries read it as they are loaded
    with ProcessPoolExecutor(WORKERS, get_context("spawn"), max_tasks_per_child=1) as pool:
        running = {pool.submit(explored, trial): trial for trial in trials}
        for ended in as_completed(running):
            error = ended.exception()
            yield running[ended], {"fault": f"{type(error).__name__}: {error}"} if error else ended.result()


def _line(name: str, told: dict[str, Any]) -> str:
    if "fault" in told:
        return f"{name}: {told['fault']}"
    values = (_value(told, where) for _, where, *_ in _METRICS)
    return f"{name}, {told['ended']}: " + " ".join(f"{value:.4g}" for value in values)


def _value(told: dict[str, Any], where: str) -> float:
    """What stands at a path of names; nan where nothing does."""
    found: Any = told
    for name in where.split("."):
        found = found.get(name) if isinstance(found, dict) else None
    return float("nan") if found is None else float(found)


def _asked(name: str, told: dict[str, Any], metric: str) -> float | None:
    """Of a part, in a metric; None: nothing."""
    built_in, file = next((asked, of_file) for known, _, _, asked, of_file in _METRICS if known == metric)
    if name not in parts.names():
        return file
    return told.get("bound") if metric == "iou" else built_in


def _rows(name: str, told: dict[str, Any]) -> Iterator[dict[str, Any]]:
    for metric, where, unit, *_ in _METRICS:
        value = _value(told, where)
        if not np.isnan(value):
            yield _row(Path(name).name, metric, value, unit, _asked(name, told, metric))


def _summed(told: dict[str, dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """Medians, and how many parts came up to what is asked of them; one without a model falls short of all."""
    for metric, where, unit, *_ in _METRICS:
        values = {name: _value(found, where) for name, found in told.items()}
        if all(np.isnan(value) for value in values.values()):
            continue
        middle = float(np.nanmedian(list(values.values())))
        yield _row(f"median of {len(told)}", metric, middle, unit, None)
        asked = {name: _asked(name, found, metric) for name, found in told.items()}
        of = [name for name in told if asked[name] is not None]
        enough = [name for name in of if _enough(values[name], asked[name], unit)]
        if of:
            yield _row(f"enough, of {len(of)}", metric, len(enough), "parts", len(of))


def _enough(value: float, asked: float | None, unit: str) -> bool:
    return asked is not None and (value <= asked if unit == "mm" else value >= asked)


def _row(name: str, metric: str, value: float, unit: str, asked: float | None) -> dict[str, Any]:
    row = {"bench": "parts", "method": name, "metric": metric, "value": value, "unit": unit}
    return row if asked is None else row | {"asked": asked}
