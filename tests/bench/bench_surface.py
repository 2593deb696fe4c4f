"""First contact, surface strokes and four-direction curvature in closed loop, over `tracking.plant`."""

from typing import Any

import numpy as np
from tracking.plant import LATE, POSE_NOISE, SPEC

from exploration.control.latency import measure_latency
from exploration.control.procedures.land import land
from exploration.control.procedures.stroke_curvature import stroke_curvature
from exploration.control.track_surface import follow_surface
from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.sensing.calibration import Calibration
from models.csg import Csg, Cube, Cylinder, Sphere
from models.solid import Solid
from primitives.pose import pose

SEEDS = 100
REST = 20  # ticks
DOWN = np.diag([1.0, -1.0, -1.0])
BODIES: dict[str, tuple[Csg, float, str]] = {
    "plane": (Cube((160.0, 160.0, 40.0)), 20.0, "plane"),
    "sphere R 15": (Sphere(15.0), 15.0, "sphere"),
    "cylinder R 20": (Cylinder(20.0, 160.0).turned("y", np.pi / 2), 20.0, "cylinder"),
    "sphere R 60": (Sphere(60.0), 60.0, "sphere"),
}


def run(seeds: int = SEEDS) -> list[dict[str, Any]]:
    """Rows of every body."""
    rows: list[dict[str, Any]] = []
    for name, (tree, top, kind) in BODIES.items():
        solid = Solid.from_csg(tree, 0.001)
        felt = np.array([_one(solid, top, kind, seed) for seed in range(seeds)])
        position, normal = np.sqrt(np.mean(felt[:, :2] ** 2, axis=0))
        for metric, value, unit, asked in (
            ("position, RMS", position, "mm", "<= 0.03"),
            ("normal, RMS", normal, "deg", "<= 0.3"),
            ("mean force against set point", float(np.mean(felt[:, 2])), "share", "0.9 to 1.1"),
            ("type right", 100.0 * float(np.mean(felt[:, 3])), "%", ">= 98"),
            ("first contact's force over that at rest, greatest", float(felt[:, 5].max()), "x", "< 1.3"),
            ("radius error over stated sigma", float(np.sqrt(np.mean(felt[:, 4] ** 2))), "", "<= 1.3"),
        ):
            row = {"bench": "surface", "method": name, "metric": metric, "value": float(value), "unit": unit}
            rows.append({**row, "asked": asked})
    return rows


def _one(solid: Solid, top: float, kind: str, seed: int) -> tuple[float, ...]:
    """RMS error [mm] and of the normal [deg], force share, type right, radius in sigmas, first contact's force."""
    rng = np.random.default_rng(seed)
    start = pose(DOWN, [1.0, -1.0, top + 6.0])
    stage, arrays = simulate(solid, [SPEC], rng, pose_noise=POSE_NOISE, start_pose=start, latency=LATE)
    guard = Guard(stage, arrays, [Calibration.nominal(SPEC)])
    guard.pending.latency = measure_latency(guard).seconds
    contact = _first_contact(guard)
    found = stroke_curvature(guard)
    radius, sigma = found.radius
    z = (radius - top) / sigma if np.isfinite(radius) and kind != "plane" else 0.0
    stroke = follow_surface(guard, np.array([np.cos(0.7), np.sin(0.7)]), 40.0, 0, 0)
    trace = stroke.trace
    off = float(np.sqrt(np.mean(solid.signed_distance(trace.points) ** 2)))
    facing = np.clip(np.sum(solid.normals(trace.points) * trace.normals, axis=1), -1.0, 1.0)
    turn = float(np.degrees(np.sqrt(np.mean(np.arccos(facing) ** 2))))
    force = float(np.mean(stroke.forces) / np.mean(stroke.set_points))
    return off, turn, force, float(found.type == kind), z, contact


def _first_contact(guard: Guard) -> float:
    """The greatest force of an approach and a landing, over that at rest."""
    forces: list[float] = []
    watching = guard.observers
    guard.observers = (*watching, lambda seen: forces.append(seen.force))
    land(guard, np.array([0.0, 0.0, -1.0]), 20.0, 25.0)
    guard.observers = watching
    return max(forces) / float(np.mean([guard.hold().force for _ in range(REST)]))
