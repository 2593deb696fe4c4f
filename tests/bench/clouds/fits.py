"""How often the truth lies within two stated deviations, by kind of parameter: 95.4 % where they are right."""

from __future__ import annotations

from collections import defaultdict
from typing import Any

import numpy as np

from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.fit import Fit, fit
from primitives.pose import frame_along, random_rotation
from primitives.shapes import Cone, Cylinder, Plane, Shape, Sphere, Torus


def two_sigma_rows(count: int) -> list[dict[str, Any]]:
    """One row a kind of parameter, over `count` fits of each shape to 12 to 100 noisy contacts of a patch."""
    inside: dict[str, list[bool]] = defaultdict(list)
    for k in range(count):
        for kind in ("plane", "cylinder", "cone", "sphere", "torus"):
            rng = np.random.default_rng([k, len(kind), ord(kind[0])])
            shape, contacts = _patch(kind, rng)
            found = fit(kind, contacts)
            if not isinstance(found, Fit):
                continue
            off = np.abs(found.shape.local(shape)) <= 2 * found.sigma  # type: ignore[arg-type]
            for name, good in zip(_names(found.shape), off, strict=True):
                inside[name].append(bool(good))
    return [
        {
            "bench": "clouds",
            "method": "palpate",
            "metric": f"truth within 2 sigma: {name} ({len(good)} parameters)",
            "value": 100 * float(np.mean(good)),
            "unit": "%",
            "asked": "92 to 98",
        }
        for name, good in sorted(inside.items())
    ]


def _names(shape: Shape) -> list[str]:
    sizes = {"cone": ["semi-angle"], "torus": ["radius", "minor radius"]}.get(shape.kind, ["radius"])
    first = ["position"] * len(shape.translations) + ["direction"] * shape.tilts
    return [*first, *sizes][: shape.dof]


def _patch(kind: str, rng: np.random.Generator) -> tuple[Shape, Contacts]:
    """A random shape, and contacts over at least a quarter turn of it."""
    n = int(rng.integers(12, 101))
    turned = random_rotation(rng)
    origin, axis = rng.uniform(-50, 50, 3), turned[:, 2]
    u, v, r = rng.uniform(-1, 1, n), rng.uniform(-1, 1, n), float(rng.uniform(5, 40))
    around = rng.uniform(np.pi / 4, np.pi) * u
    ring = np.cos(around)[:, None] * turned[:, 0] + np.sin(around)[:, None] * turned[:, 1]
    shape: Shape
    points: Floats
    if kind == "plane":
        shape, points = (
            Plane(origin, axis),
            origin + 20 * (u[:, None] * turned[:, 0] + v[:, None] * turned[:, 1]),
        )
    elif kind == "sphere":
        shape = Sphere(origin, r)
        height = 0.4 + 0.5 * v
        points = origin + r * (np.sqrt(1 - height**2)[:, None] * ring + height[:, None] * axis)
    elif kind == "cylinder":
        shape, points = Cylinder(origin, axis, r), origin + r * ring + 20 * v[:, None] * axis
    elif kind == "cone":
        angle = float(rng.uniform(0.3, 1.0))
        shape, along = Cone(origin, axis, angle), 25 + 15 * v
        points = origin + along[:, None] * (axis + np.tan(angle) * ring)
    else:
        tube = float(rng.uniform(0.2, 0.5)) * r
        shape, turn = Torus(origin, axis, r, tube), np.pi * v
        points = origin + (r + tube * np.cos(turn))[:, None] * ring + (tube * np.sin(turn))[:, None] * axis
    normals = shape.normals(points)
    sigma, tilt = float(rng.uniform(0.02, 0.2)), float(rng.uniform(0.01, 0.05))
    felt = points + sigma * rng.standard_normal((n, 1)) * normals
    across = np.stack([frame_along(m)[:, :2] @ rng.normal(0, tilt, 2) for m in normals])
    noisy = normals + across
    return shape, Contacts.of(felt, noisy / np.linalg.norm(noisy, axis=1, keepdims=True), sigma, tilt)
