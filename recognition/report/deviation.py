"""A model's surface with its distance from the truth at every point: what a page shows in color.

The signed distance to the truth is positive where the model reaches out of it.  A flat face of a mesh may be
two triangles, whose corners alone say nothing of its middle, so triangles are first halved across their longest
side until no side is longer than a step (Rivara 1984); a corner in the middle of a neighbor's side lies on that
side, so no gap shows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.solid import Solid
from primitives.arrays import Floats, Ints
from recognition.report.run_report import Deviation, ReportMesh


@dataclass(frozen=True)
class DeviationConfig:
    """How finely distances are looked at."""

    halvings: int = 6  # of the model's size, down to the longest side of a triangle
    triangles: int = 20_000  # of the refined mesh, where the model has no more itself
    least: float = 0.005  # [mm] full color, at the finest
    quantile: float = 0.98  # of the distances, that the full color stands for


def deviation(model: ReportMesh, truth: Solid, config: DeviationConfig | None = None) -> Deviation:
    """The model's surface against the truth at its pose."""
    config = config or DeviationConfig()
    fine = refined(model, config)
    distance = truth.signed_distance(fine.vertices)
    most = float(np.quantile(np.abs(distance), config.quantile)) if len(distance) else 0.0
    return Deviation(fine, distance, _round_up(max(most, config.least)))


def refined(mesh: ReportMesh, config: DeviationConfig) -> ReportMesh:
    """The same surface in triangles of no side longer than a step."""
    corners, face = mesh.vertices[mesh.triangles], mesh.face
    if not len(corners):
        return mesh
    size = float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    for halving in range(1, config.halvings + 1):
        finer = _within(corners, face, size / 2**halving, config.triangles)
        if finer is None:
            break
        corners, face = finer
    vertices, index = np.unique(np.round(corners.reshape(-1, 3), 6), axis=0, return_inverse=True)
    return ReportMesh(vertices, index.reshape(-1, 3), face)


def _within(corners: Floats, face: Ints, step: float, most: int) -> tuple[Floats, Ints] | None:
    """(t, 3, 3) triangles halved until no side is longer than `step`; None where that makes more than `most`."""
    while len(corners) <= most:
        sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
        long = sides.max(axis=1) > step
        if not long.any():
            return corners, face
        halves, owner = _halved(corners[long], sides[long].argmax(axis=1))
        corners = np.concatenate([corners[~long], halves])
        face = np.concatenate([face[~long], face[long][owner]])
    return None


def _halved(corners: Floats, side: Ints) -> tuple[Floats, Ints]:
    """(2t, 3, 3) halves of (t, 3, 3) triangles across their side number `side`, and whose each is."""
    rows = np.arange(len(corners))
    a, b, c = (corners[rows, (side + k) % 3] for k in range(3))
    middle = (a + b) / 2.0
    halves = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
    return halves, np.concatenate([rows, rows])


def _round_up(value: float) -> float:
    """To 1, 2 or 5 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(m for m in (1.0, 2.0, 5.0, 10.0) if m * power >= value * 0.999) * power)
