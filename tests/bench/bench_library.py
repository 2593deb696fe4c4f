"""A library of generated parts: what building, opening and asking cost, beside reading every file each time."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from exploration.sensing.spec import load_sensor
from models.formats.openscad.writer import write
from models.generate import generate
from models.library import Library, build
from models.part import load_part
from models.parts import build as part
from models.parts import names
from recognition.confusable import confusable

COUNT = int(os.environ.get("PALPATE_BENCH_LIBRARY", "60"))


def run() -> list[dict[str, Any]]:
    """Rows of the table."""
    rows: list[dict[str, Any]] = []

    def row(method: str, metric: str, value: float, unit: str, **more: object) -> None:
        rows.append(
            {"bench": "library", "method": method, "metric": metric, "value": value, "unit": unit} | more
        )

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for k in range(COUNT):
            write(generate(np.random.default_rng(k)), folder / f"part{k}.csg")
        built, seconds = _timed(lambda: build(folder))
        row("palpate", f"build, {COUNT} generated objects", seconds / COUNT, "s a model")
        row("palpate", "index", built.bytes / COUNT / 1000, "kB a model", asked="<= 200")
        row("palpate", "build again, nothing changed", _timed(lambda: build(folder))[1] / COUNT, "s a model")
        library, seconds = _timed(lambda: Library.open(folder))
        row("palpate", "open", 1000 * seconds / COUNT, "ms a model")
        _, seconds = _timed(lambda: [(entry.samples, entry.field) for entry in library.values()])
        row("palpate", "samples and field of all", 1000 * seconds / COUNT, "ms a model")
        few = sorted(folder.glob("*.csg"))[:10]
        _, seconds = _timed(lambda: [load_part(file) for file in few])
        row("read the files", "solids of all", 1000 * seconds / len(few), "ms a model")
    with tempfile.TemporaryDirectory() as name:
        for known in names()[:50]:
            write(part(known), Path(name) / f"{known}.csg")
        library = Library.open(name)
        pairs, seconds = _timed(lambda: confusable(library, load_sensor("lts210"), 0.3))
        row("palpate", "confusable, 50 models", seconds, "s")
        row("palpate", "pairs that random touches confuse", float(len(pairs)), "pairs")
    return rows


def _timed(call: Callable[[], Any]) -> tuple[Any, float]:
    began = time.perf_counter()
    value = call()
    return value, time.perf_counter() - began
