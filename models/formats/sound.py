"""The surface of a solid that single precision still closes: STL and glTF hold no more.

Corners of a boolean may lie as near to one another as double precision tells.  Rounded, their triangles fold over
or come open, so the surface is simplified by the least that reads back as it was.
"""

from __future__ import annotations

import numpy as np

from models.formats.crossings import crossings
from models.formats.labeled import LabeledMesh
from models.formats.repair import RepairConfig, closed
from models.solid import Solid
from primitives.errors import PalpateError

_BY = (0.0, 1e-5, 1e-4, 1e-3)  # [mm] that corners may move, tried in turn


def sound(solid: Solid) -> Solid:
    """The solid, its mesh as little simplified as a file needs, without splinters; else as it is."""
    whole = solid.without_splinters()
    tried = (whole.simplified(by) if by else whole for by in _BY)
    return next((made for made in tried if _reads_back(made)), whole)


def _reads_back(solid: Solid) -> bool:
    """Whether a file of its triangles needs no repair."""
    corners = solid.vertices.astype(np.float32).astype(np.float64)
    try:
        _, said = closed(LabeledMesh.of(corners, solid.triangles), "", RepairConfig())
    except PalpateError:
        return False
    return not said and not len(crossings(corners, solid.triangles))
