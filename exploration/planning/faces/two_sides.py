"""Two sides of a plate are no bar: a round body as thick as the plate explains its narrow sides as well."""

from __future__ import annotations

import numpy as np

from primitives.fit import Fit
from primitives.patch_graph import Face

_FACING = 0.97  # least cosine between normals of one side
_ROUND = "cylinder", "cone"
_EACH = 3  # contacts of a side, which a plane then explains


def two_sides(face: Face) -> bool:
    """Whether a face is round, or of no shape, and was felt on two opposite flat sides and nowhere between."""
    if isinstance(face.fit, Fit) and face.fit.kind not in _ROUND:
        return False
    along = face.contacts.normals @ face.contacts.normals[0]
    sides = along > _FACING, along < -_FACING
    return bool((sides[0] | sides[1]).all() and min(np.count_nonzero(side) for side in sides) >= _EACH)
