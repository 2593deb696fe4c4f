"""Rows of circular edges: radius over the bound, and how far the rim lies off where it is nearest the center.

A straight line through the same frames says what is lost without arcs.  An arc of curvature k that its bound
leaves open by s is told from a line with the chance Phi(k/s - z), by whoever takes `FALSE` of all lines for arcs;
a small boss is told from a ball as lines are from smooth surfaces (`told_apart`).  Where such a boss is found,
by its noise too, even who starts from the truth errs to one side.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from perception.bound import ZERO, fisher
from perception.edges import OURS
from perception.noise import Noise, observe
from perception.presses import ARC_RADII, disc, hole
from perception.scene import Scene
from perception.score import row
from perception.told_apart import FALSE, told
from perception.told_kind import FOUND, TOLD, told_disc
from scipy.special import ndtr, ndtri

from exploration.sensing.baselines.erf_fit import SLOPED, erf_fit
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.arc import Arc
from primitives.arrays import Floats

FAR = 1.5  # [taxels] of the rim: not found
LOOSE = (
    0.3  # of the radius: a bound beyond it says that the frame does not hold the radius, and nothing is asked
)
SOME = 40  # of the scenes, on which smooth surfaces are tried
Finder = Callable[[TactileImage], tuple[Arc, ...]]


def arc_rows(find: Finder, noise: Noise, frames: int) -> list[dict[str, Any]]:
    """Rims of bosses and of holes; `frames` over all radii of a kind."""
    rows = []
    for kind, maker in (("disc", disc), ("hole", hole)):
        rng = np.random.default_rng(sum(map(ord, kind)))
        for radius in ARC_RADII:
            scenes = [maker(rng, radius) for _ in range(max(1, frames // len(ARC_RADII)))]
            rows += _rows(f"{kind} R {radius:.0f}", find, scenes, noise, rng)
    return rows


def _rows(
    name: str, find: Finder, scenes: list[Scene], noise: Noise, rng: np.random.Generator
) -> list[dict[str, Any]]:
    turns, shifts, least, straight, bent, missed = [], [], [], [], [], 0
    limit, met = [], []  # of who is told the kind; the same where ours finds it
    pitch, radius = scenes[0].spec.array.pitch[0], scenes[0].numbers["radius"]
    for scene in scenes:
        image = observe(scene, noise, rng)
        known, truth = fisher(scene, noise), scene.found[0]
        covariance = known.joint()
        bent.append(ndtr(truth[2] / np.sqrt(covariance[2, 2]) - ndtri(1 - FALSE)))
        inward = _inward(truth)
        of_shift = np.append(inward, -1.0)
        limit.append(of_shift @ (told_disc(scene, image, name.startswith("disc")) - truth))
        arcs = find(image)
        errors = [np.append(a.center, a.radius) - truth for a in arcs]
        if lines := erf_fit(image, config=SLOPED):
            rim = truth[:2] - radius * inward
            normal = lines[0].normal
            straight.append((lines[0].offset - normal @ rim) / (normal @ inward))
        if not errors or min(abs(of_shift @ e) for e in errors) > FAR * pitch:
            missed += 1
            continue
        error = min(errors, key=lambda e: abs(of_shift @ e))
        turns.append(error[2] ** 2)
        met.append(limit[-1])
        shifts.append(of_shift @ error)
        least.append((covariance[2, 2], of_shift @ covariance @ of_shift, known.joint(ZERO)[2, 2]))
    rows = []
    if turns:
        variance = np.mean(least, axis=0)
        turned, rim = np.mean(turns), np.mean(np.square(shifts))
        ratio = np.sqrt([turned / variance[0], rim / variance[1], turned / variance[2]])
        tight = bool(np.sqrt(variance[0]) < LOOSE * radius)
        rows += [
            row("bound", f"{name}: radius RMS", np.sqrt(variance[0]), "mm"),
            row(OURS, f"{name}: radius RMS over the bound", ratio[0], "1", 1.3 if tight else None),
            row(OURS, f"{name}: radius RMS over the bound, zero known", ratio[2], "1"),
            row(OURS, f"{name}: rim RMS over the bound", ratio[1], "1"),
            row(OURS, f"{name}: rim bias toward the center", float(np.mean(shifts)), "mm", 0.02),
            row(OURS, f"{name}: rim bias, its own sigma", float(np.std(shifts)) / np.sqrt(len(shifts)), "mm"),
            row(FOUND, f"{name}: rim bias toward the center", float(np.mean(met)), "mm"),
        ]
    least_missed = 100 * (1 - float(np.mean(bent)))
    unlike = 100 * float(np.mean([told(scene, noise) for scene in scenes[:SOME]]))
    rows += [
        row(TOLD, f"{name}: rim bias toward the center", float(np.mean(limit)), "mm"),
        row(TOLD, f"{name}: rim bias, its own sigma", float(np.std(limit)) / np.sqrt(len(limit)), "mm"),
        row("bound", f"{name}: not told from a line", least_missed, "%"),
        row("bound", f"{name}: not told from a smooth surface", 100 - unlike, "%"),
    ]
    rows.append(row(OURS, f"{name}: not found", 100 * missed / len(scenes), "%"))
    if straight:
        rows.append(
            row("erf fit with slopes", f"{name}: rim bias of a straight line", np.median(straight), "mm")
        )
    return rows


def _inward(truth: Floats) -> Floats:
    """(2,) from the rim's point nearest the pad's center to the circle's center."""
    away = np.hypot(*truth[:2])
    return truth[:2] / away if away > 1e-9 else np.array([1.0, 0.0])
