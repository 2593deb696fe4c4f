"""Whether a flat face has a dent: a place where it is not, among places where it is.

A convex body's face is convex.  So places well inside the convex hull of those that were touched of one face, at
which the skin lay below the face's plane and felt nothing, prove that the object is not convex.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, KDTree

from primitives.arrays import Floats
from primitives.pose import frame_along


@dataclass(frozen=True)
class DentsConfig:
    """When free places are inside."""

    within: float = 3.0  # [mm] of the hull's sides
    clear: float = 1.8  # [mm] of all that was touched
    least: int = 5  # such places
    spread: float = 6.0  # [mm] of the touched places, along their narrower axis
    cells: int = 20  # touched places


def dented(cells: Floats, free: Floats, normal: Floats, config: DentsConfig = DentsConfig()) -> bool:
    """Of a face with a (3,) normal, touched at (n, 3) cells and free at (m, 3) places [mm]."""
    if len(cells) < config.cells or len(free) < config.least:
        return False
    turn = frame_along(normal)[:, :2]
    felt, places = cells @ turn, free @ turn
    if float(np.linalg.eigvalsh(np.cov(felt.T))[0]) < (config.spread / 3.5) ** 2:
        return False
    sides = ConvexHull(felt).equations
    inside = (places @ sides[:, :2].T + sides[:, 2]).max(axis=1) < -config.within
    if inside.sum() < config.least:
        return False
    away = KDTree(felt).query(places[inside])[0]
    return int((np.asarray(away) > config.clear).sum()) >= config.least
