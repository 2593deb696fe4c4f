"""The frame that a person would draw a model in: square to most of its primitives, from a corner of the first.

In it most turns are whole quarters and most angles round, and sides that are flush share one coordinate, which
rounding leaves shared.  The model as a whole is then put where it was felt.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from models.csg import Prism, Sphere
from primitives.arrays import Floats
from primitives.pose import frame_along, inverse, pose, rotation_exp
from recognition.assembly.piece import Piece

_SQUARE = 1e-4  # sine of the angle up to which two directions are square to each other
_DIGITS = 4  # of where the whole is put [mm]
_ROUND = ("cylinder", "cone", "torus")


def own_frame(pieces: Sequence[Piece]) -> Floats:
    """(4, 4) world_from_model; the world's own where a surface without a shape is among the pieces."""
    if any(piece.kind == "mesh" for piece in pieces):
        return np.eye(4)
    turn = max(map(_turn, pieces), key=lambda turn: sum(_is_square(piece, turn) for piece in pieces))
    first = in_frame(pieces[0], pose(turn))
    corner = first.placed.bounds()[0]
    at = first.world_from_piece[:3, 3]
    if isinstance(first.solid, Sphere):
        corner = at
    elif first.kind in _ROUND:
        along = first.world_from_piece[:3, 2]
        corner = np.where(np.abs(along) > 1.0 - _SQUARE, corner, at)
    return pose(turn, np.round(turn @ corner, _DIGITS))


def in_frame(piece: Piece, world_from_model: Floats) -> Piece:
    """The same in a (4, 4) frame; a prism along one of its axes is written by outlines along the others."""
    placed = inverse(world_from_model) @ piece.world_from_piece
    if not (isinstance(piece.solid, Prism) and _along_an_axis(placed[:3, 2])):
        return replace(piece, world_from_piece=placed)
    axis = np.round(placed[:3, 2])
    side = np.roll(np.abs(axis), 1)
    turn = np.column_stack([side, np.cross(axis, side), axis])
    rolled = (turn.T @ placed[:3, :3])[:2, :2]
    outline = tuple((float(x), float(y)) for x, y in np.array(piece.solid.outline) @ rolled.T)
    return replace(
        piece, solid=replace(piece.solid, outline=outline), world_from_piece=pose(turn, placed[:3, 3])
    )


def _turn(piece: Piece) -> Floats:
    """(3, 3) rotation that a piece is square to: a prism along its longest side, what is round about its axis."""
    turn = piece.world_from_piece[:3, :3]
    if isinstance(piece.solid, Sphere):
        return np.eye(3)
    if isinstance(piece.solid, Prism):
        outline = np.array(piece.solid.outline)
        sides = np.roll(outline, -1, axis=0) - outline
        x, y = sides[int(np.argmax(np.linalg.norm(sides, axis=1)))]
        return np.asarray(turn @ rotation_exp([0.0, 0.0, float(np.arctan2(y, x))]))
    return frame_along(turn[:, 2]) if piece.kind in _ROUND else turn


def _is_square(piece: Piece, turn: Floats) -> bool:
    """Whether a piece has its sides along the axes of a (3, 3) rotation, or its own axis along one."""
    own = turn.T @ _turn(piece)
    if isinstance(piece.solid, Sphere):
        return True
    return all(map(_along_an_axis, own[:, 2:].T if piece.kind in _ROUND else own.T))


def _along_an_axis(direction: Floats) -> bool:
    return bool(np.abs(direction).max() > 1.0 - 0.5 * _SQUARE**2)
