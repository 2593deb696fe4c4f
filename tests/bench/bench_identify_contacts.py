"""Identify at the level of contacts: many runs of every policy, touches drawn by ray casting with a stated noise.

Every policy meets the same parts at the same poses (`recognizing.ray_hand`).  PALPATE_BENCH_RUNS sets the runs of
the choice by information (100 are asked, 20 by default); the other policies make a quarter of them, at least 4.
The area is that under the share of right names over device time, up to the longest run, as a share of it.  Beside
the pose is what the likeliest pose of the right object is off, given these contacts and their noise,
started at the truth: edges under the skin are no part of it.
"""

from __future__ import annotations

import os
from typing import Any, NamedTuple

import numpy as np
from bench_recognize import wilson
from recognizing.ray_hand import RayHand, RayNoise

from models import parts
from models.library import Entry, Library
from models.solid import Solid
from models.symmetry import pose_error
from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.pose import inverse, pose, random_rotation
from recognition.identifying.identify import Identifier, IdentifyConfig
from recognition.identifying.options import POLICIES
from recognition.matching import Belief
from recognition.matching.align import refine
from recognition.matching.facets import facets_of

RUNS = int(os.environ.get("PALPATE_BENCH_RUNS", "20"))
BOX = np.array([-300.0, -300.0, -300.0, 300.0, 300.0, 300.0])
LONGEST = 400.0  # [s] over which the area is taken
SURE = 0.95


class Told(NamedTuple):
    """One run."""

    right: bool
    sure: bool
    confidence: float
    touches: int
    seconds: float
    off: tuple[float, float] | None  # [mm], [deg]
    limit: tuple[float, float] | None  # of the likeliest pose
    steps: tuple[
        tuple[float, bool, float], ...
    ]  # device time; whether the name was right then; its probability

    @property
    def named(self) -> float:
        """[s] of the device from which on the right name had `SURE`; of the whole run where it never had."""
        at = self.seconds
        for seconds, right, probability in reversed(self.steps):
            if not (right and probability >= SURE):
                break
            at = seconds
        return at

    @property
    def met(self) -> float:
        """[s] of the device until something was met, whatever the policy is."""
        return next((at for at, _, probability in self.steps if probability > 0.0), self.seconds)


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
    steps = [(s.seconds, *_stated(s.belief, name)) for s in identifier.run()]
    belief = identifier.told
    if belief is None:
        return Told(False, False, 0.0, hand.cost.touches, hand.cost.seconds, None, None, tuple(steps))
    best = belief.best(name) if belief.decision == name else None
    found = None if best is None else _off(library[name], best.pose, world)
    limit = (
        None
        if best is None
        else _off(library[name], _likeliest(library[name], hand, identifier, world), world)
    )
    return Told(
        belief.decision == name, identifier.ended == "sure", belief.confidence, hand.cost.touches,
        hand.cost.seconds, found, limit, tuple(steps),
    )  # fmt: skip


def _stated(belief: Belief | None, name: str) -> tuple[bool, float]:
    return (False, 0.0) if belief is None else (belief.decision == name, belief.confidence)


def _off(entry: Entry, found: Floats, world: Floats) -> tuple[float, float]:
    """[mm], [deg] up to symmetry."""
    error = pose_error(entry.symmetry, found, world)
    return error.distance, float(np.degrees(error.angle))


def _likeliest(entry: Entry, hand: RayHand, identifier: Identifier, world: Floats) -> Floats:
    """(4, 4) from each touch's middle and normal with the noise that they have, started at the truth."""
    noise: RayNoise = hand.noise
    each = [t.contacts for t in identifier.touches if t.met and len(t.contacts)]
    middle = np.array([c.points.mean(axis=0) for c in each])
    normals = np.array([c.normals[0] for c in each])
    felt = np.isfinite(normals).all(axis=1)
    sigma = np.where(felt, np.hypot(noise.place, noise.each), 0.4)
    c = Contacts.of(middle, normals, sigma, noise.turn)
    at = np.ascontiguousarray(inverse(world)[None, :3])
    whole = np.ascontiguousarray(np.where(felt[:, None], normals, 0.0))
    done = refine(at, np.ascontiguousarray(middle), whole, felt, np.array(c.sigma), np.array(c.normal_sigma),
                  np.ones(len(c)), facets_of(entry.solid.body), 1.0)  # fmt: skip
    return inverse(pose(done.poses[0][:, :3], done.poses[0][:, 3]))


def _area(told: list[Told]) -> float:
    """Mean share of the time up to the longest, at which the name was right; the last one holds."""
    total = 0.0
    for t in told:
        ends = [*(at for at, _, _ in t.steps[1:]), LONGEST]
        total += sum(
            max(min(end, LONGEST) - at, 0.0) * hit for (at, hit, _), end in zip(t.steps, ends, strict=True)
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
        ("device time until its name had 95 %, mean", float(np.mean([t.named for t in told])), "s", None),
        ("of that, until anything was met, mean", float(np.mean([t.met for t in told])), "s", None),
        ("right", float(np.mean([t.right for t in told])), "share", None),
        (f"sure and wrong of {len(sure)} [{low:.3f}..{high:.3f}]", wrong / max(len(sure), 1), "share",
         f"<= {1.0 - float(np.mean([t.confidence for t in sure])) if sure else 0.0:.3f}"),
        ("area under accuracy over time", _area(told), "share", None),
    ]  # fmt: skip
    asked = iter(("<= 0.1", "<= 0.15", "<= 0.4", "<= 0.6"))
    limit = np.array([t.limit for t in told if t.limit is not None]).reshape(-1, 2)
    for where, rows in (("", off), (", likeliest from the truth", limit)):
        for share, what in ((0.5, "median error"), (0.95, "95th percentile")):
            for column, kind, unit in ((0, "place", "mm"), (1, "attitude", "deg")):
                if len(rows):
                    value = float(np.quantile(rows[:, column], share))
                    found.append((f"{kind}, {what}{where}", value, unit, next(asked, None)))
    return [
        {"bench": "identify, contacts", "method": policy, "metric": metric, "value": value, "unit": unit}
        | ({} if asked is None else {"asked": asked})
        for metric, value, unit, asked in found
    ]
