"""A plate as its two sides show it: outlines of where both faces are there, and of where neither is."""

from __future__ import annotations

from dataclasses import dataclass

from primitives.arrays import Floats


@dataclass(frozen=True, eq=False)
class Plate:
    """Two flat faces that look away from each other, or one over another, seen together along their normal.

    Rims are closed loops of (n, 2) corners x, y [mm] in the plate's frame; a place is in a region where it lies
    inside an odd number of its rims.
    """

    pose: Floats  # (4, 4) world_from_plate, z along the upper face's normal, the origin half way between the two
    thick: float  # [mm] from the one face to the other
    there: tuple[Floats, ...]  # rims of where both were felt; of a step, the upper one
    missing: tuple[Floats, ...]  # rims of where neither is; of a step, over and beside its floor
    lies: bool = False  # on a table, so that nobody saw the lower face: what is told is told of the upper one
    step: bool = False  # the lower face looks up as well, as a floor: what is missing is so down to it
