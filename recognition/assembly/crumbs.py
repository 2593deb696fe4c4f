"""What hangs in the air apart from a body, and was felt nowhere, is taken away.

Surfaces that were only inferred may bound a second piece far from all contacts, down to the end of the workspace.
Of bodies that touch can tell, each piece was touched (our derivation).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.csg import Cube
from primitives.arrays import Floats
from primitives.pose import pose
from recognition.assembly.made import CRUMB, Body
from recognition.assembly.piece import Piece

UNFELT = "a piece apart from the others, which nobody felt, is left out"


@dataclass(frozen=True)
class CrumbsConfig:
    """Which pieces go, and how they are cut."""

    near: float = 1.0  # [mm] from its box, within which a contact is on a piece
    most: float = 0.2  # of all volume: what is larger stays
    past: float = 0.05  # [mm] of a cut all round it
    aside: float = 0.01  # of a piece's volume, that its cut may take from others


def without_crumbs(body: Body, felt: Floats, config: CrumbsConfig = CrumbsConfig()) -> Body:
    """A body without pieces that no (n, 3) contact [mm] is on, each taken away by a box of its own."""
    if not len(felt):
        return body
    volumes = [(float(part.volume()), part) for part in body.solid.body.mesh.decompose()]
    pieces = sorted(
        [lot for lot in volumes if lot[0] > CRUMB], key=lambda lot: lot[0]
    )  # a cavity's is negative
    whole = sum(volume for volume, _ in pieces)
    for volume, part in pieces[:-1]:
        low, high = np.array(part.bounding_box()).reshape(2, 3)
        on_it = ((felt > low - config.near) & (felt < high + config.near)).all(axis=1)
        if volume > config.most * whole or on_it.any():
            continue
        made = body.less(_box(low - config.past, high + config.past), torn=True)
        if made is not None and body.solid.volume - made.solid.volume < (1.0 + config.aside) * volume:
            body = made
    return body


def _box(low: Floats, high: Floats) -> Piece:
    """What takes away all between two (3,) corners."""
    x, y, z = (high - low).tolist()
    middle, open_ends = pose(translation=0.5 * (low + high)), ((None, None),) * 3
    return Piece("cube", "subtract", Cube((x, y, z)), middle, None, open_ends, UNFELT)
