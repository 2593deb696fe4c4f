"""Which stops of strokes the known faces explain, because one stands there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from exploration.planning.touching.study import Wall
from primitives.arrays import Bools, Floats
from primitives.fit import Fit
from primitives.patch_graph import Face


@dataclass(frozen=True)
class ExplainedConfig:
    """How far a stop may be from the face that explains it."""

    met: float = 4.0  # [mm] from where a stroke met a wall, within which a face explains it
    against: float = -0.3  # most cosine between the way of the stroke and the face's normal
    round_off: float = 25.0  # [mm] from the contacts of a round face, or its radius, up to which it explains


def unexplained_stops(
    walls: Sequence[Wall], faces: Sequence[Face], config: ExplainedConfig = ExplainedConfig()
) -> list[Wall]:
    """What strokes met where no known face stands."""
    at = np.array([wall.point for wall in walls]).reshape(-1, 3)
    ways = np.array([wall.heading for wall in walls]).reshape(-1, 3)
    told = np.zeros(len(walls), dtype=bool)
    for face in faces:
        if isinstance(face.fit, Fit):
            near = np.abs(face.fit.shape.signed_distance(at)) < config.met
            if face.fit.kind != "plane":
                near &= _felt_round(face, at, config.round_off)
            side = 1.0 if face.fit.convex else -1.0
            told |= near & (side * (face.fit.shape.normals(at) * ways).sum(axis=1) < config.against)
    return [wall for wall, known in zip(walls, told, strict=True) if not known]


def _felt_round(face: Face, points: Floats, least: float) -> Bools:
    """Which of (n, 3) points lie no farther from a round face's contacts than it is round."""
    assert isinstance(face.fit, Fit)
    far = max(least, getattr(face.fit.shape, "radius", 0.0))
    return np.asarray(KDTree(face.contacts.points).query(points)[0] < far)
