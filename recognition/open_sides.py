"""Where a body has a side that no face ends.

A primitive that was added may be open: nothing that was felt says how far it goes, and it ends with the contacts.
Whether the body has such a side depends on what else was added and taken away: one that other primitives cover is
none of the body's.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from models.solid import Solid
from primitives.arrays import Floats
from primitives.pose import inverse, transform_points
from recognition.assembly import Assembly, NotClosed
from recognition.assembly.piece import Piece

_ENDED = "cube", "cylinder", "prism", "cone"  # kinds that end at planes
_ON = 0.01  # [mm] from a plane, of a facet that is on it
_AREA = 0.1  # [mm^2] of a side, less than which a boolean may leave where two surfaces touch
ALONG = 0.99  # least cosine between two ways that are one


def open_ended(assembly: Assembly | NotClosed) -> bool:
    """Whether a primitive that faces added has a side that none ends; a cone that has none closes by itself."""
    if isinstance(assembly, NotClosed):
        return False
    return any(True for piece in _added(assembly) if piece.kind != "cone" for _ in _open(piece))


def open_ways(assembly: Assembly) -> list[Floats]:
    """(3,) each way along which the body has a side that no face ends."""
    found: list[Floats] = []
    for piece in _added(assembly):
        for axis, side in _open(piece):
            way = side * piece.world_from_piece[:3, axis]
            if not any(way @ other > ALONG for other in found) and _has_side(
                assembly.solid, piece, axis, side
            ):
                found.append(way)
    return found


def _added(assembly: Assembly) -> Iterator[Piece]:
    """What faces added, and not what was felt once the body stood."""
    return (piece for piece in assembly.pieces if piece.operation == "add" and not piece.why)


def _open(piece: Piece) -> Iterator[tuple[int, float]]:
    """Axes along which it is open, and to which side; the outline of a prism is whole, and so is an apex."""
    if piece.kind not in _ENDED:
        return
    rows = list(enumerate(piece.ends)) if piece.kind == "cube" else [(2, piece.ends[-1])]
    for axis, (below, above) in rows:
        if below is None:
            yield axis, -1.0
        if above is None and piece.kind != "cone":
            yield axis, 1.0


def _has_side(solid: Solid, piece: Piece, axis: int, side: float) -> bool:
    """Whether a solid has a facet where a piece of it ends on one side."""
    low, high = piece.solid.bounds()
    own = transform_points(inverse(piece.world_from_piece), solid.vertices)
    end = (low if side < 0.0 else high)[axis]
    facets = own[solid.triangles[(np.abs(own[:, axis] - end) < _ON)[solid.triangles].all(axis=1)]]
    middle = facets.mean(axis=1)
    within = ((middle > low - _ON) & (middle < high + _ON)).all(axis=1)
    area = 0.5 * np.cross(facets[:, 1] - facets[:, 0], facets[:, 2] - facets[:, 0])[:, axis] * side
    return float(area[within & (area > 0.0)].sum()) > _AREA
