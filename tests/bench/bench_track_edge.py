"""Edges tracked in closed loop: straight ones by dihedral angle and speed, circles, outlines, roundings; time.

The plant is `tracking.plant`.  An error is the distance of a point of the final trace perpendicular to the true
edge, in space; the dihedral angle is felt by one touch behind the edge, and the trace set back by it.  A row
stands for PALPATE_BENCH_SEEDS seeds (default 10; a hundred take about half an hour), all points of them together.
"""

import os
import time
from collections.abc import Iterable
from dataclasses import dataclass
from math import erf, sqrt
from typing import Any

import numpy as np
import trimesh
from tracking.outlines import disc, off_outline, outlines, prism, rounded_bar, share_traced
from tracking.plant import SPEC, Start, guard_over, outlined, tracked, with_dihedral

from exploration.control.edge_profile import EdgeProfile
from exploration.control.track_edge import Tracked
from exploration.control.track_outline import TrackedOutline
from exploration.sensing.lines.edge_rounding import half_height, rounding_of, spread
from exploration.sensing.response import Response, rubber
from models.raycast import has_embree
from models.solid import Solid
from recognition.tracking.traced import described, loop_gap

SEEDS = int(os.environ.get("PALPATE_BENCH_SEEDS", "10"))
DIHEDRALS = (60.0, 90.0, 120.0, 150.0)
RADII = (10.0, 20.0, 40.0, 60.0)
LENGTH = 100.0  # [mm] of a straight edge
LOOP = 600.0  # [mm] at most
ROUNDINGS = (0.5, 1.0, 2.0, 3.0, 5.0)  # [mm]
ROWS = ("time", *(f"{d:.0f}" for d in DIHEDRALS), "fast", "circles", "outlines", "roundings")


@dataclass(frozen=True)
class Trial:
    """One track against the truth."""

    off: np.ndarray  # (n,) [mm]
    ended: str
    forces: np.ndarray  # over their set points
    gap: float | None = None  # [mm]
    radius: float | None = None  # [mm]
    angle: float | None = None  # [deg] between a straight edge and the truth
    dihedral: float | None = None  # [deg]
    traced: float | None = None  # share of a loop


def run(rows: tuple[str, ...] = ROWS, seeds: int = SEEDS) -> list[dict[str, Any]]:
    """Rows of the table."""
    if unknown := sorted(set(rows) - set(ROWS)):
        raise SystemExit(f"no rows {unknown[0]!r}; there are: {', '.join(ROWS)}")
    out: list[dict[str, Any]] = []
    for angle in DIHEDRALS:
        for speed in (20.0,) * (f"{angle:.0f}" in rows) + (60.0,) * ("fast" in rows):
            trials = [straight(angle, speed, seed) for seed in range(seeds)]
            out += _straight_rows(f"{angle:.0f} deg, {speed:.0f} mm/s", angle, speed, trials)
    if "circles" in rows:
        for radius in RADII:
            solid, ring = disc(radius)
            trials = [loop(solid, ring, (997 * seed) % len(ring), seed) for seed in range(seeds)]
            out += _loop_rows(f"circle R {radius:.0f}", trials, radius)
    if "outlines" in rows:
        for name, (solid, ring, at) in outlines().items():
            out += _loop_rows(name, [loop(solid, ring, at, seed) for seed in range(seeds)])
    if "roundings" in rows:
        for radius in ROUNDINGS:
            out += rounding_rows(radius, [rounding(radius, seed) for seed in range(seeds)])
    return out + (time_rows() if "time" in rows else [])


def straight(dihedral_deg: float, speed: float, seed: int) -> Trial:
    """One straight edge, along z through the origin."""
    x, y, z = np.eye(3)
    start = Start(np.array([0.0, 0.0, 60.0]), -z, x, y)
    guard = guard_over(prism(dihedral_deg), start, seed)
    found = tracked(guard, start, LENGTH, speed)
    if found.trace is None:
        return Trial(np.empty(0), "lost", _ratios(found))
    trace, angle = with_dihedral(guard, found.trace)
    along = described(trace).direction
    return Trial(
        np.hypot(trace.points[:, 0], trace.points[:, 1]),
        found.ended,
        _ratios(found),
        angle=float(np.degrees(np.arcsin(np.linalg.norm(np.cross(along, z))))),
        dihedral=None if angle is None else float(np.degrees(angle)),
    )


def loop(solid: Solid, ring: np.ndarray, at: int, seed: int) -> Trial:
    """One outline at z = 0, counterclockwise, from its point number `at`."""
    along = np.append(ring[(at + 1) % len(ring)] - ring[at - 1], 0.0)
    along /= np.linalg.norm(along)
    up = np.array([0.0, 0.0, 1.0])
    start = Start(np.append(ring[at], 0.0), along, np.cross(along, up), up)
    guard = guard_over(solid, start, seed)
    found = outlined(guard, start, LOOP, 20.0)
    if not found:
        return Trial(np.empty(0), "lost", _ratios(found))
    whole = found.traces[0] if len(found.traces) == 1 else None
    points = np.concatenate([trace.points for trace in found.traces])
    return Trial(
        off_outline(points, ring),
        found.ended,
        _ratios(found),
        loop_gap(found.traces) if found.ended == "closed" else None,
        described(whole).radius if whole else None,
        traced=share_traced(points, ring),
    )


@dataclass(frozen=True)
class Rounded:
    """What one track along a rounded edge told."""

    radius: float  # [mm]
    bound: float  # [mm] standard deviation that nobody can better who has the same frames


def rounding(radius: float, seed: int) -> Rounded | None:
    """To what a square edge is felt to be rounded, from one track along it."""
    x, y, z = np.eye(3)
    start = Start(np.array([-min(radius, 3.0), 0.0, 60.0]), -z, x, y)
    guard = guard_over(rounded_bar(radius), start, seed)
    found = tracked(guard, start, LENGTH, 20.0)
    if found.ended != "length" or found.profile is None:
        return None
    p, response = found.profile, rubber(SPEC.elastomer.spread, SPEC.array.pitch)
    felt = rounding_of(p.place, p.depth, p.sigma, p.width, response, 0.5 * np.pi, 0.0).radius
    return Rounded(felt, _rounding_bound(p, radius, response))


def _rounding_bound(profile: EdgeProfile, radius: float, response: Response) -> float:
    """[mm] Cramer-Rao: press, slope and place of the edge are free, the response is known."""
    press = float(profile.depth[-len(profile.depth) // 4 :].mean())
    truth = np.array([radius, press, 0.0, -half_height(radius, press, 0.5 * np.pi)])
    steps = np.diag([0.05, 0.01, 0.002, 0.05])

    def shown(p: np.ndarray) -> np.ndarray:
        return spread(profile.place - p[3], p[0], p[1], p[2], profile.width, response, 0.5 * np.pi)

    slopes = [(shown(truth + h) - shown(truth - h)) / (2.0 * h.max() * profile.sigma) for h in steps]
    return float(np.sqrt(np.linalg.inv(np.array(slopes) @ np.transpose(slopes))[0, 0]))


def rounding_rows(radius: float, found: list[Rounded | None]) -> list[dict[str, Any]]:
    """What is told of edges that are rounded to `radius` [mm]."""
    name, felt = f"rounded {radius:g} mm", [r for r in found if r is not None]
    out = [_row(name, "lost", len(found) - len(felt), f"of {len(found)}", "0")]
    if felt:
        off, bound = np.array([abs(r.radius - radius) for r in felt]), rms([r.bound for r in felt])
        out += [
            _row(name, "rounding, rms error", rms(off), "mm"),
            _row(name, "the same at the Cramer-Rao bound", bound, "mm"),
            _row(name, "rounding within 0.3 mm", 100.0 * np.mean(off <= 0.3), "%", "100"),
            _row(name, "the same at the Cramer-Rao bound", 100.0 * erf(0.3 / bound / sqrt(2.0)), "%"),
        ]
    return out


def time_rows(tracks: int = 5) -> list[dict[str, Any]]:
    """Ticks a second of a whole closed loop, simulated array and stage and final trace with it, on one core.

    Processor time, as other jobs may share the machine.  The bare call is one `first_hits` of `models.raycast`
    with embree, as a simulated array makes it, with 160 rays at a ball of 20,480 triangles.  It takes about 20
    microseconds, and ten of those are the tick of 5,000 a second.  How many calls at the bar that is tracked, of 8
    triangles, go into a tick is told beside it: those hardly cast.
    """
    x, y, z = np.eye(3)
    start, solid = Start(np.array([0.0, 0.0, 60.0]), -z, x, y), prism(90.0)
    round_ = trimesh.creation.icosphere(5, 60.0)
    ball = Solid.from_mesh(round_.vertices, round_.faces)
    per_tick, bare, fine = [], [], []
    for seed in range(tracks + 1):
        guard = guard_over(solid, start, seed)
        before, began = guard.cost.frames, time.process_time()
        found = tracked(guard, start, LENGTH, 20.0)
        if found.trace is None:
            raise RuntimeError(f"the edge of seed {seed} was lost")
        per_tick.append((time.process_time() - began) / (guard.cost.frames - before))
        bare.append(bare_call(solid, 0.0))
        fine.append(bare_call(ball, 60.0))
    tick = float(np.median(per_tick[1:]))
    out = [_row("closed loop", "ticks a second", 1.0 / tick, "1/s", ">= 5000")]
    if has_embree():
        for name, calls, asked in (("20,480", fine, "<= 10"), ("8", bare, None)):
            call = float(np.median(calls[1:]))
            scene = f"bare 160-ray call, {name} triangles"
            out += [
                _row(scene, "time", 1e6 * call, "us"),
                _row("closed loop", f"tick over the {scene}", tick / call, "x", asked),
            ]
    return out


def bare_call(solid: Solid, top: float, calls: int = 400) -> float:
    """[s] the median of bare embree calls with 160 rays down -y at the solid, whose top is at y = `top`."""
    if not has_embree():
        return np.nan
    u, v = np.meshgrid(np.linspace(-13.5, 13.5, 16), np.linspace(-8.1, 8.1, 10))
    origins = np.stack([v.ravel(), np.full(u.size, top + 5.0), u.ravel()], axis=1).astype(np.float32)
    down = np.tile(np.float32([0.0, -1.0, 0.0]), (u.size, 1))
    caster, took = solid.body.caster, []
    for _ in range(calls):
        began = time.perf_counter()
        caster.first_hits(origins, down)
        took.append(time.perf_counter() - began)
    return float(np.median(took))


def _straight_rows(name: str, dihedral_deg: float, speed: float, trials: list[Trial]) -> list[dict[str, Any]]:
    out = _common_rows(name, trials, "<= 0.03" if speed < 40.0 else "<= 0.06", "length")
    angles = [t.angle for t in trials if t.angle is not None]
    felt = [t.dihedral for t in trials if t.dihedral is not None]
    if angles:
        out.append(_row(name, "angle of the edge, rms", rms(angles), "deg", "<= 0.05"))
    if felt:
        out.append(_row(name, "dihedral, rms error", rms(np.array(felt) - dihedral_deg), "deg", "<= 1"))
    out.append(_row(name, "dihedral not felt", len(trials) - len(felt), "tracks", "0"))
    return out


def _loop_rows(name: str, trials: list[Trial], radius: float | None = None) -> list[dict[str, Any]]:
    out = _common_rows(name, trials, "<= 0.06", "closed")
    gaps = [t.gap for t in trials if t.gap is not None]
    radii = [t.radius for t in trials if t.radius is not None]
    traced = [t.traced for t in trials if t.traced is not None and t.ended == "closed"]
    if traced:
        out.append(_row(name, "share of the loop that was traced, mean", 100.0 * np.mean(traced), "%"))
    if gaps:
        out.append(_row(name, "gap of the loop, greatest", max(gaps), "mm", "<= 0.15"))
    if radius is not None and radii:
        out.append(
            _row(name, "radius, greatest error", max(np.abs(np.array(radii) - radius)), "mm", "<= 0.05")
        )
    return out


def _common_rows(name: str, trials: list[Trial], asked: str, well: str) -> list[dict[str, Any]]:
    """What every row of the table says; `asked` of the RMS."""
    good = [t for t in trials if t.ended == well]
    forces = np.concatenate([t.forces for t in trials])
    out = [_row(name, "lost", len(trials) - len(good), f"of {len(trials)}", "0")]
    if good:
        off = np.concatenate([t.off for t in good])
        out += [
            _row(name, "rms", rms(off), "mm", asked),
            _row(name, "within 0.1 mm", 100.0 * np.mean(off < 0.1), "%", "99.9"),
        ]
    if len(forces):
        out += [
            _row(
                name, "force within 10 %", 100.0 * np.mean(np.abs(forces - 1.0) < 0.1), "% of ticks", ">= 95"
            ),
            _row(name, "greatest force over its set point", forces.max(), "x"),
        ]
    return out


def rms(values: Iterable[float]) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(np.asarray(values, dtype=float)))))


def _ratios(found: Tracked | TrackedOutline) -> np.ndarray:
    return np.array(found.forces) / np.array(found.set_points)


def _row(method: str, metric: str, value: float, unit: str, asked: str | None = None) -> dict[str, Any]:
    told = {"bench": "track_edge", "method": method, "metric": metric, "value": float(value), "unit": unit}
    return told | ({} if asked is None else {"asked": asked})
