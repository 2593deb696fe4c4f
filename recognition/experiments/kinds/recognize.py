"""A trial that names an object from contacts on its surface, which nobody chose.

Contacts are even by area.  What is out of reach is the share of the surface that lies farthest along a random
direction.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from models.part import load_part
from models.solid import Solid
from primitives.arrays import Floats
from primitives.evidence import Contacts
from recognition.experiments.kinds.libraries import library_of, told_of
from recognition.experiments.settings import Value
from recognition.experiments.trial import Work
from recognition.matching import Evidence, Prior, match
from recognition.running.simulation import WorldConfig, random_pose

BOX = np.array([[-300.0] * 3, [300.0] * 3])  # [mm] that the object is somewhere in
TILT = 0.02  # [rad] 1 sigma of a normal about each of two axes
LEAST_SIGMA = 1e-3  # [mm] that a contact without noise is said to have


def carry(settings: Mapping[str, Value], work: Work) -> dict[str, Value]:
    """Touch, match, and say whether the name is right."""
    s: Mapping[str, Any] = settings
    part = load_part(work.file(s["part"]))
    library = library_of(s, part.name, work)
    rng = np.random.default_rng(s["seed"])
    solid = part.solid.placed(random_pose(part.solid, BOX, rng, WorldConfig()))
    points, normals = reached(solid, s["contacts"], s["occlusion"], rng)
    points = points + s["sigma_mm"] * rng.standard_normal(points.shape)
    normals = normals + TILT * rng.standard_normal(normals.shape)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    contacts = Contacts.of(
        points,
        normals if s["normals"] else None,
        sigma=max(s["sigma_mm"], LEAST_SIGMA),
        normal_sigma=TILT,
    )
    began = time.perf_counter()
    belief = match(Evidence(contacts), library, Prior.around(contacts))
    took = time.perf_counter() - began
    return {**told_of(belief, library, part.name, solid), "wall_seconds": took}


def reached(solid: Solid, count: int, occlusion: float, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """(count, 3) points and normals of the part of the surface that is in reach."""
    corners = solid.vertices[solid.triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(across, axis=1)
    many = int(np.ceil(4 * count / (1.0 - occlusion))) + 100
    chosen = rng.choice(len(area), many, p=area / area.sum())
    u, v = rng.random((2, many))
    over = u + v > 1.0
    u, v = np.where(over, 1.0 - u, u), np.where(over, 1.0 - v, v)
    a, b, c = np.moveaxis(corners[chosen], 1, 0)
    points = a + u[:, None] * (b - a) + v[:, None] * (c - a)
    along = points @ rng.standard_normal(3)
    within = np.flatnonzero(along <= np.quantile(along, 1.0 - occlusion))[:count]
    return points[within], across[chosen[within]] / area[chosen[within], None]
