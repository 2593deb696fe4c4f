"""How much contacts scatter, from the contacts alone.

Every contact is compared with the plane through its nearest neighbors (weighted least squares; where normals were
felt, the plane across the mean normal).  With m neighbors fitted by three parameters the residual at the contact
has variance sigma^2 (1 + h), h its leverage, and edges and bends only add to it.  So its lower part is looked at:
the quartile of |r| over that of a normal variable, 0.3186 (our derivation).  Readings of one place tell how far
the reading shakes, and nothing of the face: they are one neighbor.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from primitives.arrays import Floats
from primitives.evidence import Contacts
from recognition.sources.places import one_a_place

_NEIGHBORS = 8
_MOST = 4000  # contacts that are looked at
_QUARTILE, _OF_NORMAL = 0.25, 0.3186  # of |r|, and that of a unit normal
_LEAST = 1e-5  # of the contacts' extent, and below it no sigma is believed


def estimated_sigma(contacts: Contacts) -> float:
    """[mm] one standard deviation of the contacts along the normal."""
    return sigma_of_places(one_a_place(contacts))


def sigma_of_places(contacts: Contacts) -> float:
    """[mm] the same of contacts of which no two are of one place."""
    points = contacts.points
    extent = float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 1.0
    floor = max(_LEAST * extent, 1e-6)
    if len(points) <= _NEIGHBORS:
        return max(0.005 * extent, floor)
    picked = np.linspace(0, len(points) - 1, min(len(points), _MOST)).astype(np.int64)
    tree = cKDTree(points)
    near = np.asarray(tree.query(points[picked], k=_NEIGHBORS + 1)[1])
    residual = _residuals(points[near])
    sigma = float(np.quantile(np.abs(residual), _QUARTILE)) / _OF_NORMAL
    return max(sigma, floor)


def _residuals(groups: Floats) -> Floats:
    """(n,) of the first of each group of points to the plane through the others, scaled by its leverage."""
    own, others = groups[:, 0], groups[:, 1:]
    middle = others.mean(axis=1)
    arms = others - middle[:, None]
    values, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", arms, arms))
    offset = np.einsum("ni,nij->nj", own - middle, axes)
    spread = np.maximum(values, 1e-300)
    leverage = 1.0 / others.shape[1] + offset[:, 1] ** 2 / spread[:, 1] + offset[:, 2] ** 2 / spread[:, 2]
    kept: Floats = offset[:, 0] / np.sqrt(1.0 + leverage)
    return kept
