"""First contact, surface strokes, four-direction curvature and the ends of faces in closed loop.

The plant is `tracking.plant`.  A row stands for PALPATE_BENCH_SEEDS seeds (default 10; a hundred take an hour).
What is true is read from the body and, where it changes along that as a cone's radius does, at the true pose.
"""

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from tracking.plant import LATE, POSE_NOISE, SPEC
from tracking.surfaces import BODIES, ENDS, Body

from exploration.control.latency import measure_latency
from exploration.control.procedures.land import land
from exploration.control.procedures.stroke_curvature import stroke_curvature
from exploration.control.track_surface import follow_surface
from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.sensing.calibration import Calibration
from models.solid import Solid
from primitives.pose import pose

SEEDS = int(os.environ.get("PALPATE_BENCH_SEEDS", "10"))
REST = 20  # ticks
DOWN = np.diag([1.0, -1.0, -1.0])
LONGEST = 100.0  # [mm] of a stroke that should end before
ROWS = (*BODIES, *ENDS)


@dataclass(frozen=True)
class Felt:
    """One landing, four strokes and one more."""

    position: float  # [mm] rms error
    normal: float  # [deg] rms error
    force: float  # mean over set point
    order: bool  # right
    type: bool  # right
    surprise: float  # error of the radius over its stated sigma
    contact: float  # force of the first contact over that at rest


@dataclass(frozen=True)
class Ended:
    """One stroke toward where a face ends."""

    stopped: bool  # by the edge
    inside: float  # [mm] from the pad's center to where the surface ends; below 0: over it
    sighted: float  # [mm] from where the edge was seen to where it is; inf: not seen


def run(rows: tuple[str, ...] = ROWS, seeds: int = SEEDS) -> list[dict[str, Any]]:
    """Rows of every body."""
    out: list[dict[str, Any]] = []
    for name, body in BODIES.items():
        if name in rows:
            solid = body.solid()
            out += _body_rows(name, [stroked(solid, body, seed) for seed in range(seeds)])
    for name, body in ENDS.items():
        if name in rows:
            solid = body.solid()
            out += _end_rows(name, [ended(solid, body, seed) for seed in range(seeds)])
    return out


def stroked(solid: Solid, body: Body, seed: int) -> Felt:
    """Land beside the highest place, stroke it four ways, and follow it along a fifth."""
    guard = _guard(solid, body, seed)
    contact = _first_contact(guard)
    radius = body.radius + body.tangent * float(guard.stage._true[0, 3])
    found = stroke_curvature(guard)
    felt, sigma = found.radius
    surprise = (felt - radius) / sigma if np.isfinite(felt) and np.isfinite(radius) else 0.0
    stroke = follow_surface(guard, np.array([np.cos(0.7), np.sin(0.7)]), 40.0, 0, 0)
    trace = stroke.trace
    facing = np.clip(np.sum(solid.normals(trace.points) * trace.normals, axis=1), -1.0, 1.0)
    return Felt(
        float(np.sqrt(np.mean(solid.signed_distance(trace.points) ** 2))),
        float(np.degrees(np.sqrt(np.mean(np.arccos(facing) ** 2)))),
        float(np.mean(stroke.forces) / np.mean(stroke.set_points)),
        found.order == body.order,
        found.type == body.kind,
        surprise,
        contact,
    )


def ended(solid: Solid, body: Body, seed: int) -> Ended:
    """Land on a face and stroke it to its end; any way on a flat one, along its axis on a round one."""
    guard = _guard(solid, body, seed)
    _first_contact(guard)
    angle = np.random.default_rng([seed, 1]).uniform(-np.pi, np.pi)
    angle = angle if body.kind == "plane" else np.pi * (seed % 2)
    heading = np.array([np.cos(angle), np.sin(angle)])
    stroke = follow_surface(guard, heading, LONGEST, 0, 0)
    true = guard.stage._true
    way = true[:3, :2] @ heading
    face = -true[:3, 2]
    under = true[:3, 3] + 0.5 * face
    steps = np.arange(-20.0, 40.0, 0.02)
    over = solid.signed_distance(under - 1.5 * face + steps[:, None] * way) > 0.0
    ends = float(steps[np.flatnonzero(over & (steps > -20.0))[0]]) if over.any() else np.inf
    place = under + ends * way
    seen = [abs(float((edge.point - place) @ edge.outward)) for edge in stroke.edges]
    return Ended(stroke.ended == "edge", ends, min(seen, default=np.inf))


def _guard(solid: Solid, body: Body, seed: int) -> Guard:
    """In the air over the highest place, a little beside it; its latency is measured."""
    start = pose(DOWN, [1.0, -1.0, body.top + 6.0])
    rng = np.random.default_rng(seed)
    stage, arrays = simulate(solid, [SPEC], rng, pose_noise=POSE_NOISE, start_pose=start, latency=LATE)
    guard = Guard(stage, arrays, [Calibration.nominal(SPEC)])
    guard.pending.latency = measure_latency(guard).seconds
    return guard


def _first_contact(guard: Guard) -> float:
    """The greatest force of an approach and a landing, over that at rest."""
    forces: list[float] = []
    watching = guard.observers
    guard.observers = (*watching, lambda seen: forces.append(seen.force))
    land(guard, np.array([0.0, 0.0, -1.0]), 20.0, 25.0)
    guard.observers = watching
    return max(forces) / float(np.mean([guard.hold().force for _ in range(REST)]))


def _body_rows(name: str, felt: list[Felt]) -> list[dict[str, Any]]:
    def rms(values: list[float]) -> float:
        return float(np.sqrt(np.mean(np.square(values))))

    return [
        _row(name, "position, RMS", rms([f.position for f in felt]), "mm", "<= 0.03"),
        _row(name, "normal, RMS", rms([f.normal for f in felt]), "deg", "<= 0.3"),
        _row(
            name, "mean force against set point", float(np.mean([f.force for f in felt])), "x", "0.9 to 1.1"
        ),
        _row(name, "order right", 100.0 * float(np.mean([f.order for f in felt])), "%", ">= 99.5"),
        _row(name, "type right", 100.0 * float(np.mean([f.type for f in felt])), "%", ">= 98"),
        _row(name, "radius error over stated sigma", rms([f.surprise for f in felt]), "", "<= 1.3"),
        _row(name, "first contact over rest, greatest", max(f.contact for f in felt), "x", "< 1.3"),
    ]


def _end_rows(name: str, found: list[Ended]) -> list[dict[str, Any]]:
    sighted = [f.sighted for f in found if np.isfinite(f.sighted)]
    return [
        _row(name, "stopped by the edge", 100.0 * float(np.mean([f.stopped for f in found])), "%", "100"),
        _row(name, "stopped short of it by, least", min(f.inside for f in found), "mm", "> 0"),
        _row(name, "edge seen", 100.0 * len(sighted) / len(found), "%"),
        _row(name, "edge seen beside itself, median", float(np.median(sighted or [np.inf])), "mm"),
    ]


def _row(method: str, metric: str, value: float, unit: str, asked: str | None = None) -> dict[str, Any]:
    told = {"bench": "surface", "method": method, "metric": metric, "value": float(value), "unit": unit}
    return told if asked is None else {**told, "asked": asked}
