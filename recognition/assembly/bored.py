"""Round holes in a body that few of the faces bound, as in the hull of all contacts.

Such a body has none of the walls that were felt or inferred.  Those of a round hole say enough by themselves: what
is inside of them is taken away, where no more than strays were felt there (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from models.csg import Cylinder as Bar
from primitives.arrays import Floats
from primitives.evidence import NOT_FELT
from primitives.pose import frame_along, pose
from primitives.shapes import Cylinder, Shape
from recognition.assembly.given import FittedFace
from recognition.assembly.made import Body
from recognition.assembly.piece import Piece

_LEFT = np.pi  # [rad] round its axis, that at most no contact of a hole lies in
BORED = "a round hole is taken out of a body that its wall bounds no side of"
_ROWS = 0.3  # of the length of a hole's contacts, that a wall which nobody felt goes on past them
_PAST = 1.0  # [mm] that any does
_INSIDE = 1.5  # [mm] in a hole, from where a contact contradicts it
_WITHIN = 0.2  # share of a hole, from which it lies in a body and does not only pass it
_STRAYING = 0.002  # share of all contacts that may


def bored(body: Body, faces: Sequence[FittedFace], shapes: Sequence[Shape], felt: Floats) -> Body:
    """A body less the round holes among the faces, whose `shapes` these are; (n, 3) places were `felt`."""
    for number, (face, shape) in enumerate(zip(faces, shapes, strict=True)):
        if not is_hole(shape, face):
            continue
        assert isinstance(shape, Cylinder)
        along = (face.contacts.points - shape.anchor) @ shape.direction
        low, high = float(along.min()), float(along.max())
        guessed = not (face.contacts.touch != NOT_FELT).any()
        past = _PAST + (_ROWS * (high - low) if guessed else 0.0)
        middle = shape.anchor + 0.5 * (low + high) * shape.direction
        bar = Bar(shape.radius, high - low + 2.0 * past)
        where = pose(frame_along(shape.direction), middle)
        piece = Piece("cylinder", "subtract", bar, where, number, ((None, None),), BORED)
        inside = int((piece.placed.signed_distance(felt) < -_INSIDE).sum())
        less = body.less(piece) if inside <= _STRAYING * len(felt) else None
        hollow = _WITHIN * np.pi * shape.radius**2 * (high - low)
        if less is not None and body.solid.volume - less.solid.volume > hollow:
            body = less
    return body


def is_hole(shape: Shape, face: FittedFace) -> bool:
    """Whether it is the wall of a round hole, and no hollow as between two fingers: its contacts go round."""
    if face.fit.convex or not isinstance(shape, Cylinder) or not len(face.contacts):
        return False
    across = (face.contacts.points - shape.anchor) @ frame_along(shape.direction)[:, :2]
    turns = np.sort(np.arctan2(across[:, 1], across[:, 0]))
    gaps = np.diff(turns, append=turns[0] + 2.0 * np.pi)
    return bool(gaps.max() < _LEFT)
