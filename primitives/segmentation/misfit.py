"""What each contact costs on a shape: its squared whitened distance, and that of its normal's angle.

A normal that was not felt but follows from neighbors has no sense, and may belong to another face nearby: its
angle is that between lines, and costs no more than a bound.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from primitives.arrays import Bools, Floats, Ints
from primitives.evidence import Contacts
from primitives.shapes import Shape

MOST_TURNED = 6.0  # chi2 of a normal that was not felt


@dataclass(frozen=True)
class Oriented:
    """Contacts that all have a normal, ready to be compared with many shapes."""

    contacts: Contacts
    weight: Floats  # (n,) 1 / sigma [1/mm]
    turn_weight: Floats  # (n,) 1 / normal_sigma [1/rad]
    felt: Bools  # (n,) whether the normal was felt

    @staticmethod
    def of(contacts: Contacts, felt: Bools) -> Oriented:
        """Of contacts with normals."""
        return Oriented(contacts, 1.0 / contacts.sigma, 1.0 / contacts.normal_sigma, felt)

    def __len__(self) -> int:
        return len(self.contacts)

    def select(self, rows: Ints) -> Oriented:
        """Those of (k,) rows."""
        return Oriented(
            self.contacts.select(rows), self.weight[rows], self.turn_weight[rows], self.felt[rows]
        )

    def chi2(self, shape: Shape, sign: float) -> Floats:
        """(n,) of every contact on one shape; `sign` is -1 where the material is outside."""
        points = self.contacts.points
        distance = shape.signed_distance(points) * self.weight
        cosine = sign * (shape.normals(points) * self.contacts.normals).sum(axis=1)
        return np.asarray(distance**2 + turned(cosine, self.turn_weight, self.felt))


def turned(cosine: Floats, weight: Floats, felt: Bools) -> Floats:
    """(..., n) chi2 of angles between normals."""
    angle = np.arccos(np.clip(np.where(felt, cosine, np.abs(cosine)), -1.0, 1.0))
    chi2 = (angle * weight) ** 2
    return np.asarray(np.where(felt, chi2, np.minimum(chi2, MOST_TURNED)))
