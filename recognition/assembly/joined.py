"""Pieces that lie apart, joined: a bar or a box goes on from an end that nobody felt to what it points at.

No object lies in pieces.  Where a bar stands on a ring no pad lies on the last of it, so that contact ends before
the bar does.  It holds nothing that an array passed through (our derivation).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

import numpy as np

from models.csg import Cube, Cylinder
from models.solid import Solid
from primitives.arrays import Floats
from primitives.pose import transform_points
from recognition.assembly.made import among, drawn, thinned
from recognition.assembly.piece import Piece, tree_of

JOINED = "a piece of which an end was not felt is joined to what it points at"
_REACH = 25.0  # [mm] from such an end to what it points at
_STEP = 0.25  # [mm] at which it is looked along the way
_ROOT = 0.5  # of what it points at, along the way, that it goes into
_DEEPEST = 8.0  # [mm] the same
_RIM = 0.9  # of an end's half width, where it is looked along the way
_HITS = 0.3  # of such places, that must point at something
_DEEP = 0.5  # [mm] under the surface, from which what was felt is buried
_STRAYS = 2  # places that may be
_SAMPLES = 2000  # of what is added, to ask how much of it was passed through
_NEAR = 2.0  # [mm] from a place that was passed through, that is so too
_EMPTY = 0.12  # of it at most


def joined(
    pieces: Sequence[Piece], unfelt: Collection[int], free: Floats | None, felt: Floats, facet: float
) -> tuple[Piece, ...]:
    """The pieces, some of them longer where they lie apart; as they are where nothing joins them.

    Nobody felt the surfaces `unfelt`; nothing is at (n, 3) places `free` [mm], and (m, 3) `felt` ones are on it.
    """
    now, nowhere = tuple(pieces), np.empty((0, 3)) if free is None else thinned(free, _NEAR)
    on = thinned(felt, _NEAR)
    parts = (solid := Solid.from_csg(tree_of(now), facet)).parts
    while parts > 1:
        for _, k, longer, added in sorted(_longer(now, solid, unfelt), key=lambda found: found[0]):
            tried = (*now[:k], longer, *now[k + 1 :])
            whole = Solid.from_csg(tree_of(tried), facet)
            buried = _buried(whole, on) > _buried(solid, on) + _STRAYS
            if whole.parts < parts and not buried and not _passed_through(added, whole, nowhere):
                now, solid, parts = tried, whole, whole.parts
                break
        else:
            return now
    return now


def _longer(
    pieces: Sequence[Piece], solid: Solid, unfelt: Collection[int]
) -> Iterator[tuple[float, int, Piece, Piece]]:
    """[mm] to what a piece points at, its number, the piece that reaches there, and what is added to it."""
    for k, piece in enumerate(pieces):
        if piece.operation != "add" or not isinstance(piece.solid, Cube | Cylinder):
            continue
        axes = range(3) if isinstance(piece.solid, Cube) else (2,)
        for axis, ends in zip(axes, piece.ends, strict=True):
            for above, end in enumerate(ends):
                if end is not None and end not in unfelt:
                    continue
                found = _ahead(piece, axis, 1.0 if above else -1.0, solid)
                if found is None:
                    continue
                gap, by = found
                longer = piece.longer(axis, bool(above), by)
                added = longer.longer(axis, not above, -piece.size(axis))
                yield gap, k, longer, added


def _ahead(piece: Piece, axis: int, side: float, solid: Solid) -> tuple[float, float] | None:
    """[mm] from one end of a piece to what it points at, and by how much it is longer when it goes on into that.

    A bar may be bored, and what it points at as well: both are looked for behind all of the end.
    """
    feet = _end(piece, axis)
    feet[:, axis] = 0.5 * side * piece.size(axis)
    out = side * piece.world_from_piece[:3, axis]
    steps = np.arange(_STEP, 2.0 * _REACH, _STEP)
    places = transform_points(piece.world_from_piece, feet)[:, None] + steps[:, None] * out
    inside = solid.signed_distance(places.reshape(-1, 3)).reshape(len(feet), -1) < 0.0
    inside = inside[~inside[:, 0] & inside[:, steps <= _REACH].any(axis=1)]
    if len(inside) < _HITS * len(feet):
        return None
    gap = np.argmax(inside, axis=1)
    through = np.array([int(np.argmin(row[k:])) or len(row) - k for row, k in zip(inside, gap, strict=True)])
    far = float(steps[gap].max())
    return far, far + min(_ROOT * float(np.median(through)) * _STEP, _DEEPEST)


def _end(piece: Piece, axis: int) -> Floats:
    """(9, 3) places across one axis of a piece, in its own frame: its middle and near its rim all round."""
    turn = np.arange(8) * np.pi / 4.0
    if isinstance(piece.solid, Cylinder):
        half = _RIM * np.full(2, piece.solid.radius)
    else:
        half = _RIM * 0.5 * np.array([piece.size(k) for k in range(3) if k != axis])
    flat = np.vstack([np.zeros(2), half * np.column_stack([np.cos(turn), np.sin(turn)])])
    return np.insert(flat, axis, 0.0, axis=1)


def _buried(solid: Solid, felt: Floats) -> int:
    """How many of (n, 3) felt places lie in a body."""
    return int((solid.signed_distance(felt) < -_DEEP).sum()) if len(felt) else 0


def _passed_through(added: Piece, whole: Solid, free: Floats) -> bool:
    """Whether an array went through what is added, where nothing takes it away again."""
    low, high = added.placed.bounds()
    some = drawn(low, high, _SAMPLES)
    some = some[np.asarray(added.placed.signed_distance(some) < 0.0) & (whole.signed_distance(some) < 0.0)]
    return float(among(some, free, _NEAR).mean()) > _EMPTY if len(some) else True
