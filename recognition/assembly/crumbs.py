"""What hangs in the air apart from a body, and was felt nowhere, is taken away.

Surfaces that were only inferred may bound a second piece far from all contacts, down to the end of the workspace.
Of bodies that touch can tell, each piece was touched (our derivation).
"""

from __future__ import annotations

import numpy as np

from models.csg import Cube
from primitives.arrays import Floats
from primitives.pose import pose
from recognition.assembly.made import CRUMB, Body
from recognition.assembly.piece import Piece

UNFELT = "a piece apart from the others, which nobody felt, is left out"
_NEAR = 1.0  # [mm] from its box, within which a contact is on a piece
_ROUND = 0.05  # [mm] of a cut all round it
_MOST = 0.2  # of all volume: what is larger is none
_ASIDE = 0.01  # of a piece's volume, that its cut may take from others


def without_crumbs(body: Body, felt: Floats) -> Body:
    """A body without pieces that no (n, 3) contact [mm] is on, each taken away by a box of its own."""
    parts = [
        part for part in body.solid.body.mesh.decompose() if part.volume() > CRUMB
    ]  # a cavity's is negative
    if not len(felt):
        return body
    whole = sum(part.volume() for part in parts)
    for part in sorted(parts, key=lambda part: float(part.volume()))[:-1]:
        low, high = np.array(part.bounding_box()).reshape(2, 3)
        if part.volume() > _MOST * whole or ((felt > low - _NEAR) & (felt < high + _NEAR)).all(axis=1).any():
            continue
        size, middle = high - low + 2.0 * _ROUND, 0.5 * (low + high)
        box = Cube((float(size[0]), float(size[1]), float(size[2])))
        nothing = (None, None)
        piece = Piece(
            "cube", "subtract", box, pose(translation=middle), None, (nothing, nothing, nothing), UNFELT
        )
        made = body.less(piece, torn=True)
        if made is not None:
            lost = body.solid.volume - made.solid.volume
            if lost <= (1.0 + _ASIDE) * part.volume() + 1e-3:
                body = made
    return body
