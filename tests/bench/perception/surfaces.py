"""Rows of smooth contacts: the order of the surface, its radius over the bound, and where its points lie.

A small ball and a flat pin, both hardly wider than the blur, are nearly one and the same to the pad: whoever calls
each what it is equally often does so with the chance Phi(d/2), d^2 being the chi2 between their clean frames.
Ours calls what may be either a ball, which claims less, and so is right of balls more often.
"""

from typing import Any

import numpy as np
from perception.bound import ZERO, fisher
from perception.edges import OURS
from perception.noise import Noise, observe
from perception.presses import ball, bar, flat
from perception.scene import Scene, world_from_sensor
from perception.score import row
from perception.told_apart import even

from exploration.sensing.contacts import contacts_of
from exploration.sensing.touch import perceive
from primitives.arrays import Floats

BALLS = (10.0, 20.0, 40.0, 80.0, 150.0, 200.0)  # [mm]
BARS = (10.0, 20.0, 40.0, 80.0, 150.0, 300.0, 500.0)  # [mm]
WANDER = 3.0  # [mm]
SOME = 20  # of the balls, beside which pins are tried


def curvature_rows(noise: Noise, frames: int) -> list[dict[str, Any]]:
    """The plane, and each radius of ball and bar, by so many frames."""
    rng = np.random.default_rng(31)
    rows = _rows("plane", "plane", [flat(rng) for _ in range(frames)], noise, rng)
    for radius in BARS:
        scenes = [bar(rng, radius, WANDER) for _ in range(frames)]
        rows += _rows(f"cylinder R {radius:.0f}", "cylinder or cone", scenes, noise, rng)
    for radius in BALLS:
        scenes = [ball(rng, radius, WANDER) for _ in range(frames)]
        rows += _rows(f"sphere R {radius:.0f}", "sphere", scenes, noise, rng)
    return rows


def _rows(
    name: str, order: str, scenes: list[Scene], noise: Noise, rng: np.random.Generator
) -> list[dict[str, Any]]:
    right, errors, least, normals, away = 0, [], [], [], []
    for scene in scenes:
        image = observe(scene, noise, rng)
        touch = perceive(image)
        if not touch.surface:
            continue
        right += touch.surface.order == order
        found, _ = touch.surface.radius
        if order != "plane" and np.isfinite(found):
            radius = scene.numbers["radius"]
            errors.append(found / radius - 1)
            known = fisher(scene, noise)
            least.append((known.joint()[0, 0] / radius**2, known.joint(ZERO)[0, 0] / radius**2))
        contacts = contacts_of(touch, world_from_sensor(scene.numbers))
        if len(contacts):
            away.extend(_away(order, contacts.points, scene))
            normals.append(np.degrees(np.arccos(np.clip(contacts.normals[0, 2], -1, 1))))
    rows = [row(OURS, f"{name}: order right", 100 * right / len(scenes), "%", 99.0)]
    if order == "sphere":
        pins = 100 * float(np.mean([even(scene, noise) for scene in scenes[:SOME]]))
        rows.append(row("bound", f"{name}: told from a flat pin, either as often", pins, "%"))
    if errors:
        variance = np.mean(least, axis=0)
        ratio = np.sqrt(np.mean(np.square(errors)) / variance)
        rows += [
            row("bound", f"{name}: radius RMS", 100 * np.sqrt(variance[0]), "%"),
            row(OURS, f"{name}: radius RMS over the bound", ratio[0], "1", 1.3),
            row(OURS, f"{name}: radius RMS over the bound, zero known", ratio[1], "1"),
            row(OURS, f"{name}: radius, bias", 100 * float(np.mean(errors)), "%"),
        ]
    if away:
        rows.append(row(OURS, f"{name}: point along normal, RMS", 1e3 * _rms(away), "um", 10.0))
    if order == "plane":
        rows.append(row(OURS, f"{name}: normal, RMS", _rms(normals), "deg", 0.1))
    return rows


def _away(order: str, points: Floats, scene: Scene) -> Floats:
    """Distance of points of the part frame from the true surface [mm]."""
    x, y, z = points.T
    if order == "plane":
        return z
    radius = scene.numbers["radius"]
    across = np.hypot(y, z + radius)
    return (across if order != "sphere" else np.hypot(x, across)) - radius


def _rms(values: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
