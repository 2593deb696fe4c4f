"""What each contact costs on a shape: its squared whitened distance, and that of its normal's angle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.shapes import Shape


@dataclass(frozen=True)
class Oriented:
    """Contacts that all have a normal, ready to be compared with many shapes."""

    contacts: Contacts
    weight: Floats  # (n,) 1 / sigma [1/mm]
    turn_weight: Floats  # (n,) 1 / normal_sigma [1/rad]

    @staticmethod
    def of(contacts: Contacts) -> Oriented:
        """Of contacts with normals."""
        return Oriented(contacts, 1.0 / contacts.sigma, 1.0 / contacts.normal_sigma)

    def __len__(self) -> int:
        return len(self.contacts)

    def chi2(self, shape: Shape, sign: float) -> Floats:
        """(n,) of every contact on one shape; `sign` is -1 where the material is outside."""
        points = self.contacts.points
        distance = shape.signed_distance(points) * self.weight
        cosine = sign * (shape.normals(points) * self.contacts.normals).sum(axis=1)
        turned = np.arccos(np.clip(cosine, -1.0, 1.0)) * self.turn_weight
        return np.asarray(distance**2 + turned**2)
