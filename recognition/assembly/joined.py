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
from recognition.assembly.made import among, drawn, thinned
from recognition.assembly.piece import Piece, tree_of

JOINED = "a piece of which an end was not felt is joined to what it points at"
_REACH = 25.0  # [mm] from such an end to what it points at
_STEP = 0.25  # [mm] at which it is looked along the way
_ROOT = 0.5  # of what it points at, along the way, that it goes into
_DEEPEST = 8.0  # [mm] the same
_SAMPLES = 2000  # of what is added, to ask how much of it was passed through
_NEAR = 2.0  # [mm] from a place that was passed through, that is so too
_EMPTY = 0.12  # of it at most


def joined(
    pieces: Sequence[Piece], unfelt: Collection[int], free: Floats | None, facet: float
) -> tuple[Piece, ...]:
    """The pieces, some of them longer where they lie apart; as they are where nothing joins them.

    Nobody felt the surfaces `unfelt`; nothing is at (n, 3) places `free` [mm].
    """
    now, nowhere = tuple(pieces), np.empty((0, 3)) if free is None else thinned(free, _NEAR)
    parts = (solid := Solid.from_csg(tree_of(now), facet)).parts
    while parts > 1:
        for _, k, longer, added in sorted(_longer(now, solid, unfelt), key=lambda found: found[0]):
            tried = (*now[:k], longer, *now[k + 1 :])
            if not _passed_through(added, nowhere):
                whole = Solid.from_csg(tree_of(tried), facet)
                if whole.parts < parts:
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
                out = piece.world_from_piece[:3, axis] * (1.0 if above else -1.0)
                foot = piece.world_from_piece[:3, 3] + 0.5 * piece.size(axis) * out
                steps = np.arange(_STEP, 2.0 * _REACH, _STEP)
                inside = solid.signed_distance(foot + np.outer(steps, out)) < 0.0
                gap = int(np.argmax(inside))
                if inside[0] or not inside.any() or steps[gap] > _REACH:
                    continue
                through = int(np.argmin(inside[gap:])) or len(inside) - gap
                by = float(steps[gap]) + min(_ROOT * through * _STEP, _DEEPEST)
                longer = piece.longer(axis, bool(above), by)
                added = longer.longer(axis, not above, -piece.size(axis))
                yield float(steps[gap]), k, longer, added


def _passed_through(added: Piece, free: Floats) -> bool:
    """Whether an array went through what is added."""
    low, high = added.placed.bounds()
    some = drawn(low, high, _SAMPLES)
    some = some[np.asarray(added.placed.signed_distance(some) < 0.0)]
    return float(among(some, free, _NEAR).mean()) > _EMPTY if len(some) else True
