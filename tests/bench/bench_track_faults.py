"""Edges tracked while something fails: recovered, or stopped with the reason, and never pressed beyond the limits.

The plant is `tracking.plant`.  Halfway along a straight edge the array repeats one frame, or is silent, or the
stage stands still; or 5 % of the taxels are dead and nobody knows; or the sharp edge ends in a fillet.  A track
recovers where its final trace is within `GOOD` rms of the sharp edge over all of `LENGTH`; it stops well where
it says why, and what it traced is as good.  A row stands for PALPATE_BENCH_SEEDS seeds (default 20).
"""

import os
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from tracking import plant
from tracking.outlines import prism

from exploration.control.latency import measure_latency
from exploration.control.track_edge import EdgeConfig, follow_edge
from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.devices.simulated_array import SimulatedArray
from exploration.devices.simulated_stage import SimulatedStage
from exploration.sensing.calibration import Calibration
from exploration.sensing.frame import TaxelFrame
from models.csg import Cube, Cylinder
from models.solid import Solid
from primitives.errors import PalpateError
from primitives.pose import pose

SEEDS = int(os.environ.get("PALPATE_BENCH_SEEDS", "20"))
LENGTH = 80.0  # [mm]
GOOD = 0.1  # [mm]
HALFWAY = 400  # frames
STALLED = 20  # frames, 100 ms
FILLET = 5.0  # [mm]
DEEPEST = 1.6  # [mm] of any neighborhood of taxels: the guard's limit


@dataclass(frozen=True)
class Trial:
    """One track with a fault in it."""

    ended: str
    off: float  # [mm] rms from the sharp edge; inf without a trace
    length: float  # [mm] traced
    deepest: float  # [mm]


class Faulty:
    """An array that repeats a frame, or is silent for a while, from its `HALFWAY`th frame on."""

    def __init__(self, array: SimulatedArray, kind: str) -> None:
        self._array, self._kind, self._count = array, kind, 0
        self._stuck: TaxelFrame | None = None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._array, name)

    def read(self) -> TaxelFrame:
        """The next frame."""
        self._count += 1
        frame = self._array.read()
        if self._count == HALFWAY and self._kind == "stall":
            for _ in range(STALLED - 1):
                frame = self._array.read()
        if HALFWAY <= self._count < HALFWAY + STALLED and self._kind == "frozen":
            self._stuck = self._stuck or frame
            return replace(frame, counts=self._stuck.counts)
        return frame


class Short:
    """A stage that goes no farther along z than it does halfway."""

    def __init__(self, stage: SimulatedStage) -> None:
        self._stage = stage

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stage, name)

    def move(self, twist: np.ndarray) -> None:
        """Follow a twist, unless that leads on."""
        on = float(self._stage.pose()[2, :3] @ np.asarray(twist)[:3])
        self._stage.move(np.zeros(6) if self._stage.pose()[2, 3] < 20.0 and on < 0.0 else twist)


def run(seeds: int = SEEDS) -> list[dict[str, Any]]:
    """Rows of every fault."""
    rows: list[dict[str, Any]] = []
    for kind in ("dead taxels", "frozen", "stall", "short stage", "fillet"):
        trials = [one(kind, seed) for seed in range(seeds)]
        well = [t.off <= GOOD and (t.ended != "length" or t.length > 0.9 * LENGTH) for t in trials]
        values = (
            (
                "recovered",
                100.0 * np.mean([w and t.ended == "length" for w, t in zip(well, trials, strict=True)]),
                "%",
            ),
            ("recovered or stopped with the reason", 100.0 * np.mean(well), "%"),
            ("rms of what was traced, worst", max(t.off for t in trials), "mm"),
            ("pressed at most", max(t.deepest for t in trials), "mm"),
        )
        asked = {"recovered or stopped with the reason": "100", "pressed at most": f"<= {DEEPEST}"}
        for metric, value, unit in values:
            row = {
                "bench": "track_faults",
                "method": kind,
                "metric": metric,
                "value": float(value),
                "unit": unit,
            }
            rows.append(row | ({"asked": asked[metric]} if metric in asked else {}))
    return rows


def one(kind: str, seed: int) -> Trial:
    """One straight edge along z through the origin, or a sharp one that ends in a fillet."""
    x, y, z = np.eye(3)
    start = plant.Start(np.array([0.0, 0.0, 60.0]), -z, x, y)
    guard = _guard(_ends_in_a_fillet() if kind == "fillet" else prism(90.0), start, kind, seed)
    deepest = [0.0]
    guard.observers = (lambda seen: deepest.append(float(np.max(seen.image.depth))),)
    try:
        found = follow_edge(guard, start.along, LENGTH, 0, 0, config=EdgeConfig(speed=20.0))
    except PalpateError as fault:
        return Trial(str(fault), 0.0, 0.0, max(deepest))
    if found.trace is None:
        return Trial(found.ended, np.inf, 0.0, max(deepest))
    points = found.trace.points[found.trace.points[:, 2] > FILLET] if kind == "fillet" else found.trace.points
    off = float(np.sqrt(np.mean(points[:, 0] ** 2 + points[:, 1] ** 2)))
    return Trial(found.ended, off, float(np.ptp(found.trace.points[:, 2])), max(deepest))


def _guard(solid: Solid, start: plant.Start, kind: str, seed: int) -> Guard:
    spec = plant.SPEC
    if kind == "dead taxels":
        spec = replace(spec, electronics=replace(spec.electronics, dead=0.05))
    turn = np.stack([start.along, np.cross(-start.normal, start.along), -start.normal], axis=1)
    place = start.point - plant.INSIDE * start.outward - plant.PRESS * start.normal
    stage, (array,) = simulate(
        solid,
        [spec],
        np.random.default_rng(seed),
        pose_noise=plant.POSE_NOISE,
        start_pose=pose(turn, place + 8.0 * start.normal),
        latency=plant.LATE,
    )
    carried = Short(stage) if kind == "short stage" else stage
    guard = Guard(carried, [array], [Calibration.nominal(spec)])
    guard.pending.latency = measure_latency(guard).seconds
    guard.go_to(pose(turn, place))
    guard.hold(5)
    guard.sensors = (Faulty(array, kind),)
    return guard


def _ends_in_a_fillet() -> Solid:
    """A bar along z with its edge at the origin: sharp above z = 0, rounded below."""
    bar = Cube((60.0, 60.0, 200.0)).at(-30.0, -30.0, 0.0)
    corner = Cube((2.0 * FILLET, 2.0 * FILLET, 100.0)).at(0.0, 0.0, -50.0)
    fillet = Cylinder(FILLET, 100.0).at(-FILLET, -FILLET, -50.0)
    return Solid.from_csg(bar - corner | fillet, 0.002)
