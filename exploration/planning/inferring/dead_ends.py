"""Rims of flat faces below which no wall goes through to the face behind.

Where the next face below a rim looks the other way, and was touched just past where the wall would come out, what
the rim belongs to ends before: an engraving, or a pocket whose floor nobody felt.  How deep it is, is unknown, and
a wall down to that face would cut out what is there (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exploration.control.sighting import Sighting
from exploration.planning.open.known_face import KnownFace
from primitives.arrays import Floats


@dataclass(frozen=True)
class DeadEndsConfig:
    """When a face was touched where a wall would come out."""

    upright: float = 0.98  # least cosine between the two faces' normals, but for their sign
    near: float = 16.0  # [mm] aside, within which the face below was felt
    past: tuple[float, float] = (1.0, 6.0)  # [mm] out from the wall, where it must not have been touched
    along: float = 3.0  # [mm] to either side of the rim's middle, where that is looked at
    least: int = 2  # places


def dead_end(
    rim: Sighting, own: int, known: Sequence[KnownFace], config: DeadEndsConfig = DeadEndsConfig()
) -> bool:
    """Whether a wall below a rim of face `own` cannot go on to the next face behind it."""
    below: list[tuple[float, float, Floats]] = []
    for face in known:
        if face.face.id == own or face.fit.kind != "plane" or not len(face.cells):
            continue
        facing = face.side * float(face.fit.shape.direction @ rim.normal)
        away = face.cells - rim.point
        deep = -float(np.median(away @ rim.normal))
        aside = np.linalg.norm(away - np.outer(away @ rim.normal, rim.normal), axis=1)
        if abs(facing) > config.upright and deep > 0.0 and aside.min() < config.near:
            below.append((deep, facing, away))
    if not below:
        return False
    _, facing, away = min(below, key=lambda item: item[0])
    out, along = away @ rim.outward, np.abs(away @ rim.tangent)
    low, high = config.past
    there = (out > low) & (out < high) & (along < config.along)
    return facing < 0.0 and int(there.sum()) >= config.least
