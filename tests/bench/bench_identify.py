"""Identify built-in parts on the simulated stage, by each policy in the same run: touches, time, pose, errors.

Asked of the choice by information: at most 8 touches (median) and 20 (95th percentile).
"""

import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from models import parts
from models.library import Library
from models.solid import Solid
from recognition.identifying.options import POLICIES, IdentifyOptions
from recognition.identifying.run import run as identify

PARTS = int(os.environ.get("PALPATE_BENCH_PARTS", "10"))


def run() -> list[dict[str, Any]]:
    """Rows for the table; every policy touches the same parts at the same poses."""
    names = parts.names()
    library = Library.of({name: Solid.from_csg(parts.build(name)) for name in names})
    chosen = names[:: max(1, len(names) // PARTS)][:PARTS]
    rows: list[dict[str, Any]] = []
    for policy in POLICIES:
        told = []
        for seed, name in enumerate(chosen):
            with tempfile.TemporaryDirectory() as folder:
                options = IdentifyOptions(name, seed=seed, policy=policy, out=Path(folder) / "run")
                told.append(identify(options, library))
        rows += _rows(policy, told)
    return rows


def _rows(policy: str, told: list[dict[str, Any]]) -> list[dict[str, Any]]:
    touches, seconds = (np.array([t[key] for t in told]) for key in ("touches", "device_seconds"))
    wrong = [t for t in told if t["ended"] == "sure" and not t["truth"]["correct"]]
    off = [t["truth"]["translation_error_mm"] for t in told if t["truth"]["translation_error_mm"] is not None]
    found = [
        ("touches, median", float(np.median(touches)), "", 8),
        ("touches, 95th percentile", float(np.quantile(touches, 0.95)), "", 20),
        ("device time, median", float(np.median(seconds)), "s", None),
        ("right", sum(bool(t["truth"]["correct"]) for t in told) / len(told), "share", None),
        ("stopped sure and wrong", len(wrong) / len(told), "share", None),
        ("place, median error", float(np.median(off)) if off else float("nan"), "mm", 0.1),
    ]
    return [
        {"bench": "identify", "method": policy, "metric": metric, "value": value, "unit": unit}
        | ({} if asked is None else {"asked": asked})
        for metric, value, unit, asked in found
    ]
