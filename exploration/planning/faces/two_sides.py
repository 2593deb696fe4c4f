"""Two sides of a plate are no bar: a round body as thick as the plate explains its narrow sides as well."""

from __future__ import annotations

import numpy as np

from primitives.evidence import Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face

_FACING = 0.95  # least cosine between normals of one side and the way across the plate
_ROUND = "cylinder", "cone"
_EACH = 2, 3  # contacts of either side, and of one of them
_FLAT = 3.0  # sigmas, that they lie off one at most


def two_sides(face: Face) -> bool:
    """Whether a face is round, or of no shape, and was felt on two opposite flat sides and nowhere between."""
    if isinstance(face.fit, Fit) and face.fit.kind not in _ROUND:
        return False
    felt = face.contacts.select(face.contacts.has_normal)
    if len(felt) < sum(_EACH):
        return False
    across = np.linalg.svd(felt.normals, full_matrices=False)[2][0]
    along = felt.normals @ across
    sides = along > _FACING, along < -_FACING
    fewer, more = sorted(int(side.sum()) for side in sides)
    opposed = fewer >= _EACH[0] and more >= _EACH[1] and fewer + more == len(felt)
    return opposed and all(_flat(felt.select(side)) for side in sides)


def _flat(side: Contacts) -> bool:
    """Whether contacts lie on one plane."""
    away = side.points - side.points.mean(axis=0)
    off = away @ np.linalg.svd(away)[2][2]
    return bool(np.abs(off).max() < _FLAT * float(np.median(side.sigma)))
