"""Rows of rings: where contacts lie and how they face, beside those of the best paraboloid of the same frames."""

from dataclasses import replace
from typing import Any

import numpy as np
from perception.edges import OURS
from perception.noise import Noise, observe
from perception.presses import ring
from perception.scene import Scene, world_from_sensor
from perception.score import row

from exploration.sensing.contacts import contacts_of
from exploration.sensing.surfaces.local_surface import fit_surface
from exploration.sensing.touch import perceive
from primitives.arrays import Floats
from primitives.evidence import Contacts

RINGS = ((33.0, 6.6), (55.0, 8.0), (22.0, 6.0))  # [mm] an O-ring, a handwheel, an eye
SIDES = {"outer": 0.35, "crest": 0.0, "inner": -0.35, "saddle": -0.8}  # [rad] from the crest
PARABOLOID = "paraboloid alone"


def ring_rows(noise: Noise, frames: int) -> list[dict[str, Any]]:
    """Each ring and side by so many frames."""
    rng = np.random.default_rng(37)
    rows = []
    for radius, tube in RINGS:
        for side, around in SIDES.items():
            scenes = [ring(rng, radius, tube, around) for _ in range(frames)]
            rows += _rows(f"ring {radius:.0f} x {tube:.1f}, {side}", scenes, noise, rng)
    return rows


def _rows(name: str, scenes: list[Scene], noise: Noise, rng: np.random.Generator) -> list[dict[str, Any]]:
    off: dict[str, list[float]] = {OURS: [], PARABOLOID: []}
    turned: dict[str, list[float]] = {OURS: [], PARABOLOID: []}
    for scene in scenes:
        image = observe(scene, noise, rng)
        touch = perceive(image)
        for method, seen in ((OURS, touch), (PARABOLOID, replace(touch, surface=fit_surface(image)))):
            contacts = contacts_of(seen, world_from_sensor(scene.numbers))
            if len(contacts):
                away, turn = _errors(contacts, scene)
                off[method].append(float(np.abs(away).max()))
                turned[method].append(float(turn.max()))
    rows = []
    for method in off:
        rows.append(
            row(method, f"{name}: worst point along normal, median", 1e3 * np.median(off[method]), "um")
        )
        rows.append(row(method, f"{name}: the same, 90 of 100", 1e3 * np.quantile(off[method], 0.9), "um"))
        rows.append(row(method, f"{name}: worst normal, median", np.median(turned[method]), "deg"))
    return rows


def _errors(contacts: Contacts, scene: Scene) -> tuple[Floats, Floats]:
    """(n,) distance [mm] of contacts of the part frame from the ring, and angle [deg] to how it faces there."""
    n = scene.numbers
    c, s = np.cos(n["around"]), np.sin(n["around"])
    upright = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])  # turns about x by `around`
    x, y, z = upright @ (contacts.points + np.array([0.0, 0.0, n["tube"]])).T - [[0.0], [n["radius"]], [0.0]]
    far = np.hypot(x, y)
    way = np.stack([x * (1.0 - n["radius"] / far), y * (1.0 - n["radius"] / far), z])
    size = np.linalg.norm(way, axis=0)
    alike = ((way / size) * (upright @ contacts.normals.T)).sum(axis=0)
    return size - n["tube"], np.degrees(np.arccos(np.clip(alike, -1.0, 1.0)))
