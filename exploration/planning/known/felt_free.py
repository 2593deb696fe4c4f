"""Where the skin felt nothing while the pad lay on the object: places that hold no material.

An untouched taxel of a pressed pad says that no surface rises past the skin over it.  The pad sinks in by its
press, so a body that the faces so far predict, and that would reach far into the skin there, is contradicted: a
corner was cut off, a face lies nearer than its neighbors imply (our derivation).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from exploration.planning.known.places import Places
from primitives.arrays import Bools, Floats
from primitives.half_spaces import HalfSpaces


@dataclass(frozen=True)
class FeltFreeConfig:
    """What counts as a contradiction."""

    inside: float = 0.25  # [mm] of predicted material over a free place that contradicts the prediction
    least: int = 3  # such places beside each other, so that one dead taxel starts nothing
    cell: float = 1.0  # [mm] free places closer than this are one
    beside: float = 3.0  # [mm] from a contradiction, within which the prediction is open


class FeltFree:
    """Grows with every look."""

    def __init__(self, config: FeltFreeConfig | None = None) -> None:
        self.config = config or FeltFreeConfig()
        self._places = Places()

    def add(self, points: Floats) -> None:
        """Remember (n, 3) free places [mm]."""
        self._places.add(np.round(points / self.config.cell).astype(int), points)

    @property
    def points(self) -> Floats:
        """(n, 3) all of them [mm]."""
        return self._places.rows

    def contradictions(self, body: HalfSpaces) -> Floats:
        """(n, 3) free places inside a predicted body."""
        if not len(self._places):
            return np.empty((0, 3))
        places = self.points
        inside: Floats = places[body.signed_distance(places) < -self.config.inside]
        if len(inside) < self.config.least:
            return np.empty((0, 3))
        tree = KDTree(inside)
        crowd = tree.query_ball_point(inside, self.config.beside, return_length=True)
        return np.asarray(inside[np.asarray(crowd) >= self.config.least])

    def opened(self, predicted: Floats, body: HalfSpaces) -> Bools:
        """(n,) whether (n, 3) predicted points lie beside a contradiction."""
        found = self.contradictions(body)
        if not len(found) or not len(predicted):
            return np.zeros(len(predicted), dtype=bool)
        reach = self.config.beside
        return np.asarray(KDTree(found).query(predicted, distance_upper_bound=reach)[0] <= reach)
