"""Recognize objects of about 100 mm from contacts that are there already: names, poses, calibration, time.

Noise is 0.3 mm a coordinate and 3 degrees on normals.  Beside each score stands the limit: the same belief with
the true object started at its true pose as well: what the search loses is told from what the evidence lacks.
Shares have their 95 % interval (Wilson) in the metric's name.  PALPATE_BENCH_QUERIES sets the queries a row (500
are asked, 60 by default), PALPATE_BENCH_RIVALS those of the rivals, which take seconds each: point pair features,
Scaling Series and ICP from many starts.  The first is left out where the contrib modules of OpenCV are missing.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from recognizing.multi_start import MultiStart
from recognizing.objects import library
from recognizing.ppf import Ppf
from recognizing.scaling_series import ScalingSeries
from recognizing.trials import Trial, add_s, astray, trial

from models.library import Entry, Library
from primitives.arrays import Floats
from primitives.evidence import Contacts
from recognition.matching import Belief, Evidence, match
from recognition.matching.belief import UNKNOWN

QUERIES = int(os.environ.get("PALPATE_BENCH_QUERIES", "60"))
RIVAL_QUERIES = int(os.environ.get("PALPATE_BENCH_RIVALS", "8"))
OBJECTS = int(os.environ.get("PALPATE_BENCH_OBJECTS", "50"))
ASKED = {(12, 0): (97, 95), (20, 0): (99, 98), (50, 0): (100, 100),
         (12, 1): (88, 84), (20, 1): (95, 93), (50, 1): (99, 98)}  # fmt: skip
Rival = Callable[[Contacts], tuple[str, Floats]]  # name and world_from_object
POSED = 0.02  # of the diagonal: ADD-S of a pose that is right


class Table:
    """Rows as they come."""

    def __init__(self, bench: str = "recognize") -> None:
        self.bench = bench
        self.rows: list[dict[str, Any]] = []

    def share(self, method: str, what: str, hits: list[bool], asked: str | None = None) -> None:
        """Per cent of hits, with its interval."""
        low, high = wilson(sum(hits), len(hits))
        self.add(
            method, f"{what} [{100 * low:.0f}..{100 * high:.0f}]", 100.0 * float(np.mean(hits)), "%", asked
        )

    def add(self, method: str, metric: str, value: float, unit: str, asked: str | None = None) -> None:
        """One number."""
        row = {"bench": self.bench, "method": method, "metric": metric, "value": value, "unit": unit}
        self.rows.append(row | ({} if asked is None else {"asked": asked}))


def run() -> list[dict[str, Any]]:
    """Rows of the table."""
    table = Table()
    known = library(OBJECTS)
    for entry in known.values():
        _ = entry.samples, entry.field, entry.symmetry, entry.pairs
    match(Evidence(trial(next(iter(known.values())), 12, False, np.random.default_rng(0)).contacts), known)
    rivals: dict[str, Rival] = {"Scaling Series": ScalingSeries(known), "multi-start ICP": MultiStart(known)}
    try:
        rivals["OpenCV PPF + ICP"] = Ppf(known)
    except (ImportError, AttributeError):
        print("recognize: no OpenCV with contrib modules; PPF is left out", file=sys.stderr)
    for (count, one_sided), asked in ASKED.items():
        passive(table, known, count, bool(one_sided), asked, rivals)
    for count in (12, 20, 50):
        passive(table, known, count, False, None, {}, normals=False)
    for count in (12, 20, 50):
        held_out(table, known, count)
    for count, strays in ((20, 0), (20, 1), (20, 2), (20, 4), (12, 1), (50, 5)):
        strayed(table, known, count, strays, rivals)
    return table.rows


def passive(table: Table, known: Library, count: int, one_sided: bool, asked: tuple[int, int] | None,
            rivals: Mapping[str, Rival], normals: bool = True) -> None:  # fmt: skip
    """Names and poses of known objects."""
    where = f"{count} contacts, {'one side' if one_sided else 'all round'}{'' if normals else ', no normals'}"
    trials = trials_of(known, QUERIES, count, one_sided, normals)
    beliefs, seconds = [], []
    for t in trials:
        began = time.perf_counter()
        beliefs.append(match(Evidence(t.contacts), known))
        seconds.append(time.perf_counter() - began)
    limits = [match(Evidence(t.contacts), known, starts=[(t.name, t.world)]) for t in trials]
    for method, found, wanted in (("palpate", beliefs, asked), ("limit", limits, None)):
        right = [b.decision == t.name for b, t in zip(found, trials, strict=True)]
        table.share(method, f"top-1, {where}", right, wanted and f">= {wanted[0]}")
        placed = [_placed(b, t, known) for b, t in zip(found, trials, strict=True)]
        table.share(method, f"pose, {where}", placed, wanted and f">= {wanted[1]}")
        table.add(
            method,
            f"log-loss, {where}",
            float(np.mean([_loss(b, t) for b, t in zip(found, trials, strict=True)])),
            "nats",
        )
    right = [b.decision == t.name for b, t in zip(beliefs, trials, strict=True)]
    table.share("palpate", f"known called unknown, {where}", [b.decision == UNKNOWN for b in beliefs], "<= 2")
    table.add(
        "palpate",
        f"calibration error, {where}",
        calibration([b.confidence for b in beliefs], right),
        "",
        "<= 0.03",
    )
    chance = by_chance([b.confidence for b in beliefs])
    table.add("limit", f"calibration error by chance, were it calibrated, {where}", chance, "")
    table.add("palpate", f"query, median, {where}", float(np.median(seconds)), "s", "<= 0.3")
    mixed = [_one_in_ten(k, b, t, known) for k, (b, t) in enumerate(zip(beliefs, trials, strict=True))]
    table.add(
        "palpate",
        f"calibration error, one object in ten not in the library, {where}",
        calibration([b.confidence for b, _ in mixed], [right for _, right in mixed]),
        "",
        "<= 0.03",
    )
    for method, rival in rivals.items():
        told, seconds = [], []
        for t in trials[:RIVAL_QUERIES]:
            began = time.perf_counter()
            told.append((t, *rival(t.contacts)))
            seconds.append(time.perf_counter() - began)
        table.share(method, f"top-1, {where}", [name == t.name for t, name, _ in told])
        placed = [name == t.name and add_s(known[name], pose, t.world) < POSED for t, name, pose in told]
        table.share(method, f"pose, {where}", placed)
        table.add(method, f"query, median, {where}", float(np.median(seconds)), "s")


def _one_in_ten(k: int, belief: Belief, t: Trial, known: Library) -> tuple[Belief, bool]:
    """A belief and whether it is right; every tenth without its object, as the prior of an unknown one says.

    Each object is left out in turn: of fifty in a row every tenth would be the same five.
    """
    if (k + k // len(known)) % 10:
        return belief, belief.decision == t.name
    others = {name: known[name] for name in known if name != t.name}
    strange = match(Evidence(t.contacts), others)
    return strange, strange.decision == UNKNOWN


def held_out(table: Table, known: Library, count: int) -> None:
    """Each object touched while it is not in the library."""
    called = []
    for t in trials_of(known, QUERIES, count, False, True):
        others = {name: known[name] for name in known if name != t.name}
        called.append(match(Evidence(t.contacts), others).decision == UNKNOWN)
    table.share("palpate", f"unknown called unknown, {count} contacts", called, ">= 95")


def strayed(table: Table, known: Library, count: int, strays: int, rivals: Mapping[str, Rival]) -> None:
    """Names of known objects, and of others, where some contacts are grossly wrong."""
    where = f"{strays} of {count} contacts 5 to 30 mm off"
    rng = np.random.default_rng([count, strays])
    trials = [astray(t, known[t.name], strays, rng) for t in trials_of(known, QUERIES, count, False, True)]
    beliefs = [match(Evidence(t.contacts), known) for t in trials]
    right = [b.decision == t.name for b, t in zip(beliefs, trials, strict=True)]
    table.share("palpate", f"top-1, {where}", right)
    named = [b.hypotheses[0].name == t.name for b, t in zip(beliefs, trials, strict=True)]
    table.share("palpate", f"likeliest known name, as rivals tell it, {where}", named)
    missed = [b.decision == UNKNOWN for b in beliefs]
    table.share(
        "palpate", f"known called unknown, {where}", missed, "<= 10" if 10 * strays <= count else None
    )
    error = calibration([b.confidence for b in beliefs], right)
    what = f"calibration error where all set-ups stray so, {where}"
    table.add("palpate", what, error, "", "<= 0.03")
    others = [{name: known[name] for name in known if name != t.name} for t in trials]
    called = [match(Evidence(t.contacts), o).decision == UNKNOWN for t, o in zip(trials, others, strict=True)]
    table.share("palpate", f"unknown called unknown, {where}", called)
    for method, rival in rivals.items():
        told = [rival(t.contacts)[0] == t.name for t in trials[:RIVAL_QUERIES]]
        table.share(method, f"top-1, {where}", told)


def calibration(confidence: list[float], right: list[bool], bins: int = 10) -> float:
    """Expected calibration error: |mean confidence - share right| over bins of equal width, by their counts."""
    sure, hit = np.array(confidence), np.array(right, dtype=float)
    of = np.minimum((sure * bins).astype(int), bins - 1)
    rows = [of == k for k in range(bins) if (of == k).any()]
    return float(sum(m.mean() * abs(sure[m].mean() - hit[m].mean()) for m in rows))


def by_chance(confidence: list[float], draws: int = 300) -> float:
    """The mean of that error over so few trials, if each were right with just the probability that it states."""
    rng = np.random.default_rng(0)
    sure = np.array(confidence)
    return float(np.mean([calibration(confidence, list(rng.random(len(sure)) < sure)) for _ in range(draws)]))


def wilson(hits: int, count: int, z: float = 1.96) -> tuple[float, float]:
    """The 95 % interval of a share."""
    p, square = hits / count, z * z / count
    half = z * np.sqrt(p * (1 - p) / count + square / (4 * count))
    return (p + square / 2 - half) / (1 + square), (p + square / 2 + half) / (1 + square)


def trials_of(
    known: Mapping[str, Entry], many: int, count: int, one_sided: bool, normals: bool
) -> list[Trial]:
    rng = np.random.default_rng([count, one_sided])
    names = list(known)
    order = [names[k % len(names)] for k in range(many)]
    return [trial(known[name], count, one_sided, rng, normals) for name in order]


def _placed(belief: Belief, t: Trial, known: Mapping[str, Entry]) -> bool:
    best = belief.best(t.name) if belief.decision == t.name else None
    return best is not None and add_s(known[t.name], best.pose, t.world) < POSED


def _loss(belief: Belief, t: Trial) -> float:
    return -float(np.log(max(belief.probabilities[t.name], 1e-6)))
