"""Identify at the level of contacts: many runs of every policy, touches drawn by ray casting with a stated noise.

Every policy meets the same parts at the same poses (`recognizing.ray_hand`).  PALPATE_BENCH_RUNS sets the runs of
the choice by information (100 are asked, 20 by default); the other policies make a quarter of them, at least 4.
The area is that under the share of right names over device time, up to the longest run, as a share of it.
"""

from __future__ import annotations

import os
from typing import Any, NamedTuple

import numpy as np
from bench_recognize import wilson
from recognizing.ray_hand import RayHand

from models import parts
from models.library import Library
from models.solid import Solid
from models.symmetry import pose_error
from primitives.pose import pose, random_rotation
from recognition.identifying.identify import Identifier, IdentifyConfig
from recognition.identifying.options import POLICIES

RUNS = int(os.environ.get("PALPATE_BENCH_RUNS", "20"))
BOX = np.array([-300.0, -300.0, -300.0, 300.0, 300.0, 300.0])
LONGEST = 400.0  # [s] over which the area is taken


class Told(NamedTuple):
    """One run."""

    right: bool
    sure: bool
    confidence: float
    touches: int
    seconds: float
    off: tuple[float, float] | None  # [mm], [deg]
    steps: tuple[tuple[float, bool], ...]  # device time, and whether the name was right then


def run() -> list[dict[str, Any]]:
    """Rows of the table."""
    library = Library.of({name: Solid.from_csg(parts.build(name)) for name in parts.names()})
    rows: list[dict[str, Any]] = []
    for policy in POLICIES:
        many = RUNS if policy == "information" else max(4, RUNS // 4)
        rows += _rows(policy, [identified(library, k, policy) for k in range(many)])
    return rows


def identified(library: Library, number: int, policy: str) -> Told:
    """Part and pose follow from the number alone."""
    names = list(library)
    name = names[(7 * number) % len(names)]
    rng = np.random.default_rng([number, 17])
    solid = library[name].solid.placed(np.eye(4))
    turn = random_rotation(rng)
    world = pose(turn, rng.uniform(-40.0, 40.0, 3) - turn @ solid.bounds.mean(axis=0))
    hand = RayHand(solid.placed(world), rng)
    identifier = Identifier(hand, library, BOX, IdentifyConfig(policy), np.random.default_rng([number, 1]))
    steps = [(s.seconds, s.belief is not None and s.belief.decision == name) for s in identifier.run()]
    belief = identifier.belief
    if belief is None:
        return Told(False, False, 0.0, hand.cost.touches, hand.cost.seconds, None, tuple(steps))
    best = belief.best(name) if belief.decision == name else None
    error = None if best is None else pose_error(library[name].symmetry, best.pose, world)
    return Told(
        belief.decision == name, identifier.ended == "sure", belief.confidence, hand.cost.touches,
        hand.cost.seconds, None if error is None else (error.distance, float(np.degrees(error.angle))),
        tuple(steps),
    )  # fmt: skip


def _area(told: list[Told]) -> float:
    """Mean share of the time up to the longest, at which the name was right; the last one holds."""
    total = 0.0
    for t in told:
        ends = [*(at for at, _ in t.steps[1:]), LONGEST]
        total += sum(
            max(min(end, LONGEST) - at, 0.0) * hit for (at, hit), end in zip(t.steps, ends, strict=True)
        )
    return total / (LONGEST * len(told))


def _rows(policy: str, told: list[Told]) -> list[dict[str, Any]]:
    sure = [t for t in told if t.sure]
    wrong = sum(not t.right for t in sure)
    low, high = wilson(wrong, max(len(sure), 1))
    off = np.array([t.off for t in told if t.off is not None]).reshape(-1, 2)
    touches, seconds = np.array([t.touches for t in told]), np.array([t.seconds for t in told])
    found: list[tuple[str, float, str, str | None]] = [
        ("touches, median", float(np.median(touches)), "", "<= 8"),
        ("touches, 95th percentile", float(np.quantile(touches, 0.95)), "", "<= 20"),
        ("device time, median", float(np.median(seconds)), "s", None),
        ("device time, mean", float(np.mean(seconds)), "s", None),
        ("right", float(np.mean([t.right for t in told])), "share", None),
        (f"sure and wrong of {len(sure)} [{low:.3f}..{high:.3f}]", wrong / max(len(sure), 1), "share",
         f"<= {1.0 - float(np.mean([t.confidence for t in sure])) if sure else 0.0:.3f}"),
        ("area under accuracy over time", _area(told), "share", None),
    ]  # fmt: skip
    if len(off):
        (half_mm, half_deg), (most_mm, most_deg) = np.quantile(off, [0.5, 0.95], axis=0)
        found += [
            ("place, median error", float(half_mm), "mm", None),
            ("attitude, median error", float(half_deg), "deg", None),
            ("place, 95th percentile", float(most_mm), "mm", None),
            ("attitude, 95th percentile", float(most_deg), "deg", None),
        ]
    return [
        {"bench": "identify, contacts", "method": policy, "metric": metric, "value": value, "unit": unit}
        | ({} if asked is None else {"asked": asked})
        for metric, value, unit, asked in found
    ]
