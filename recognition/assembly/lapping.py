"""Primitives that end at another's side run on a little way into it, as a person would draw them.

Two that only abut leave a slit between them, or a film where both take away, as wide as their last digits differ:
a printer then makes two bodies, and a mesh reader finds one that touches itself.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from models.csg import Csg, Cube, Cylinder
from models.solid import Solid
from primitives.arrays import Floats
from primitives.pose import pose
from recognition.assembly.assemble import Assembly, AssemblyOptions
from recognition.assembly.piece import Piece, tree_of

_FARTHER = 1.0  # [mm] that a primitive runs on
_SLIT = 1e-3  # [mm] that slits are wide
_SPECK = 0.5  # [mm^3] that all slits hold, and less than anything that was felt


def lapped(assembly: Assembly, facet: float = AssemblyOptions().facet) -> Assembly:
    """The same body, from boxes and cylinders that run on wherever that changes nothing of it.

    Where it still falls apart, what takes away ends sooner: it may end at the very side that is added there.
    """
    made = _made(assembly, tuple(_lapped(piece, assembly.solid) for piece in assembly.pieces), facet)
    made = made if _alike(made.solid, assembly.solid) else assembly
    for number in range(len(made.pieces)):
        for place, axis, side in _ends(made.pieces[number]):
            if made.solid.shells == 1:
                return made
            piece = made.pieces[number]
            if piece.operation == "subtract" and _length(piece.solid, axis) > 2.0 * _FARTHER:
                sooner = _resized(piece, place, axis, side, -_FARTHER)
                named = (*made.pieces[:number], sooner, *made.pieces[number + 1 :])
                other = _made(made, named, facet)
                if other.solid.shells < made.solid.shells and _alike(other.solid, made.solid):
                    made = other
    return made


def _made(assembly: Assembly, named: tuple[Piece, ...], facet: float) -> Assembly:
    if all(after is before for after, before in zip(named, assembly.pieces, strict=True)):
        return assembly
    tree = tree_of(named)
    return replace(assembly, pieces=named, tree=tree, solid=Solid.from_csg(tree, facet))


def _alike(one: Solid, other: Solid) -> bool:
    """Whether two bodies differ by no more than slits."""
    return one.volume + other.volume - 2.0 * one.shared_volume(other) <= min(_SLIT * other.area, _SPECK)


def _ends(piece: Piece) -> list[tuple[int, int, int]]:
    """Place among the ends, axis and side of each end of a box or cylinder that a surface made."""
    if not isinstance(piece.solid, Cube | Cylinder):
        return []
    axis = {k: k if isinstance(piece.solid, Cube) else 2 for k in range(len(piece.ends))}
    return [
        (k, axis[k], side) for k, pair in enumerate(piece.ends) for side in (0, 1) if pair[side] is not None
    ]


def _lapped(piece: Piece, solid: Solid) -> Piece:
    if piece.operation == "intersect":
        return piece
    for place, axis, side in _ends(piece):
        if _changes_nothing(piece, axis, side, solid):
            piece = _resized(piece, place, axis, side, _FARTHER)
    return piece


def _changes_nothing(piece: Piece, axis: int, side: int, solid: Solid) -> bool:
    """Whether what lies before an end is solid where the piece adds, and empty where it takes away."""
    before = _of_length(piece.solid, axis, _FARTHER)
    away = (side - 0.5) * (_length(piece.solid, axis) + _FARTHER)
    block = Solid.from_csg(before.placed(piece.world_from_piece @ _along(axis, away)))
    wanted = block.volume if piece.operation == "add" else 0.0
    return abs(solid.shared_volume(block) - wanted) <= min(_SLIT / _FARTHER * block.volume, _SPECK)


def _resized(piece: Piece, place: int, axis: int, side: int, by: float) -> Piece:
    """A piece that is longer at an end, which is then no surface's."""
    pair = list(piece.ends[place])
    pair[side] = None
    return replace(
        piece,
        solid=_of_length(piece.solid, axis, _length(piece.solid, axis) + by),
        world_from_piece=piece.world_from_piece @ _along(axis, (side - 0.5) * by),
        ends=(*piece.ends[:place], (pair[0], pair[1]), *piece.ends[place + 1 :]),
    )


def _length(solid: Csg, axis: int) -> float:
    return solid.size[axis] if isinstance(solid, Cube) else float(2.0 * solid.bounds()[1][2])


def _of_length(solid: Csg, axis: int, length: float) -> Csg:
    if isinstance(solid, Cylinder):
        return Cylinder(solid.radius, length)
    assert isinstance(solid, Cube)
    size = list(solid.size)
    size[axis] = length
    return Cube((size[0], size[1], size[2]))


def _along(axis: int, away: float) -> Floats:
    return pose(None, away * np.eye(3)[axis])
