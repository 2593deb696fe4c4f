"""Recognizing among hundreds and thousands of generated objects: names, the time of a query, how it grows.

PALPATE_BENCH_LIBRARIES says how many, comma-separated (100,300 by default; 100,1000,10000 are asked).  Smaller
libraries are the first objects of the largest.  Queries are asked of objects that are made when they are looked
at, as a folder's are read; the index is measured on a folder of some of them.  Contacts are as in the other table
of recognizing.
"""

from __future__ import annotations

import os
import resource
import sys
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from recognizing.trials import trial

from models.formats.openscad.writer import write
from models.generate import generate
from models.library import Entry, Library, build
from models.library.entry import Computed
from models.library.pair_table import PairTable
from models.solid import Solid
from recognition.matching import Evidence, match

COUNTS = tuple(int(n) for n in os.environ.get("PALPATE_BENCH_LIBRARIES", "100,300").split(","))
QUERIES = int(os.environ.get("PALPATE_BENCH_QUERIES", "60"))
CONTACTS = 50
BUILT = 20  # objects of the folder


def run() -> list[dict[str, Any]]:
    """Rows of the table."""
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

    with tempfile.TemporaryDirectory() as name:
        for k in range(BUILT):
            write(generate(np.random.default_rng(k)), Path(name) / f"part{k}.csg")
        began = time.process_time()
        built = build(name)
        row("build, CPU", (time.process_time() - began) / BUILT, "s a model")
        row("index", built.bytes / BUILT / 1000, "kB a model", "<= 200")
    makers = {f"part{k}": partial(_entry, k) for k in range(max(COUNTS))}
    names, scores = Library(makers).pair_table
    medians = []
    for count in COUNTS:
        table = PairTable(names[:count], np.ascontiguousarray(scores[:, :count]))
        known = Library({name: makers[name] for name in names[:count]}, table=table)
        rng = np.random.default_rng(count)
        right, seconds = [], []
        for _ in range(QUERIES):
            name = names[int(rng.integers(count))]
            t = trial(known[name], CONTACTS, False, rng)
            match(Evidence(t.contacts), known)  # so that fields are at hand, as a stored library has them
            began = time.process_time()
            belief = match(Evidence(t.contacts), known)
            seconds.append(time.process_time() - began)
            right.append(belief.decision == name)
        medians.append(float(np.median(seconds)))
        row(f"top-1 of {count}, {CONTACTS} contacts", 100.0 * float(np.mean(right)), "%", ">= 97")
        row(f"query of {count}, median CPU", medians[-1], "s", "<= 1.5" if count == 10_000 else None)
        print(
            f"large library: {count} objects, {rows[-2]['value']:.1f} %, {medians[-1]:.3f} s", file=sys.stderr
        )
    row("memory", resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000.0, "MB")
    if len(COUNTS) > 1:
        slope = float(np.polyfit(np.log(COUNTS), np.log(medians), 1)[0])
        row("query time exponent", slope, "", "<= 0.5")
    return rows


def _entry(k: int) -> Entry:
    """The k-th generated object."""
    return Entry(f"part{k}", Computed(Solid.from_csg(generate(np.random.default_rng(k)))))
