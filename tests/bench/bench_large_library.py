"""Recognizing among hundreds and thousands of generated objects: names, the time of a query, how it grows.

PALPATE_BENCH_LIBRARIES says how many, comma-separated (100,300 by default; 100,1000,10000 are asked).  Smaller
libraries are the first objects of the largest.  Contacts are as in the other table of recognizing.
"""

from __future__ import annotations

import os
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from recognizing.trials import trial

from models.formats.openscad.writer import write
from models.generate import generate
from models.library import Entry, Library, build
from recognition.matching import Evidence, match

COUNTS = tuple(int(n) for n in os.environ.get("PALPATE_BENCH_LIBRARIES", "100,300").split(","))
QUERIES = int(os.environ.get("PALPATE_BENCH_QUERIES", "60"))
CONTACTS = 50


def run() -> list[dict[str, Any]]:
    """Rows of the table."""
    with tempfile.TemporaryDirectory() as name:
        return measured(Path(name))


def measured(folder: Path) -> list[dict[str, Any]]:
    """Rows of a folder that is filled first, as far as it is not."""
    rows: list[dict[str, Any]] = []

    def row(metric: str, value: float, unit: str, asked: str | None = None) -> None:
        found = {
            "bench": "large library",
            "method": "palpate",
            "metric": metric,
            "value": value,
            "unit": unit,
        }
        rows.append(found | ({} if asked is None else {"asked": asked}))

    for k in range(max(COUNTS)):
        file = folder / f"part{k:05d}.csg"
        if not file.exists():
            write(generate(np.random.default_rng(k)), file)
    began = time.perf_counter()
    built = build(folder)
    row("build", (time.perf_counter() - began) / max(COUNTS), "s a model")
    row("index", built.bytes / max(COUNTS) / 1000, "kB a model", "<= 200")
    whole = Library.open(folder)
    medians = []
    for count in COUNTS:
        known = _first(whole, count)
        table = known.pair_table
        rng = np.random.default_rng(count)
        right, seconds = [], []
        for _ in range(QUERIES):
            name = table.names[int(rng.integers(count))]
            t = trial(known[name], CONTACTS, False, rng)
            began = time.process_time()
            belief = match(Evidence(t.contacts), known)
            seconds.append(time.process_time() - began)
            right.append(belief.decision == name)
        medians.append(float(np.median(seconds)))
        row(f"top-1 of {count}, {CONTACTS} contacts", 100.0 * float(np.mean(right)), "%", ">= 97")
        row(f"query of {count}, median", medians[-1], "s", "<= 1.5" if count == 10_000 else None)
    if len(COUNTS) > 1:
        slope = float(np.polyfit(np.log(COUNTS), np.log(medians), 1)[0])
        row("query time exponent", slope, "", "<= 0.5")
    return rows


def _first(whole: Library, count: int) -> Library:
    def maker(name: str) -> Any:
        def made() -> Entry:
            return whole[name]

        return made

    return Library({name: maker(name) for name in list(whole)[:count]})
