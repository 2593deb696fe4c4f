"""Point-to-plane ICP from many even turns, the contacts' middle on the object's; the least residual wins."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from recognizing.residual import by_residual
from scipy.spatial.transform import Rotation

from models.library import Entry
from primitives.arrays import Floats
from primitives.evidence import Contacts
from recognition.matching.target import target_of

STARTS = 100


class MultiStart:
    """Nothing is trained."""

    def __init__(self, library: Mapping[str, Entry]) -> None:
        self._library = library
        self._turns = Rotation.random(STARTS, random_state=0).as_matrix()

    def __call__(self, contacts: Contacts) -> tuple[str, Floats]:
        """The name with the least residual, and its pose."""
        best: tuple[float, str, Floats] = (np.inf, "", np.eye(4))
        for name, entry in self._library.items():
            shift = target_of(entry).center - self._turns @ contacts.points.mean(axis=0)
            starts = np.concatenate([self._turns, shift[:, :, None]], axis=2)
            wider = 0.15 * target_of(entry).size / float(np.median(contacts.sigma))
            residual, at = by_residual(entry, contacts, starts, wider)
            best = min(best, (residual, name, at), key=lambda b: b[0])
        return best[1], best[2]
