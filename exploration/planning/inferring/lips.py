"""Walls that were none: a stroke under an overhang was stopped by its lip.

On the floor of a dovetail groove the housing comes to the lip over it before the skin comes to the side.  Such
stops agree on a plane straight down from the lip.  Where the side itself is known from its rims on two faces, and
leans over the floor up to that lip, the plane is no wall (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from primitives.arrays import Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.shapes import Plane


@dataclass(frozen=True)
class LipsConfig:
    """What is the lip of an overhang."""

    overhang: float = 0.2  # least cosine between the way that a side looks and the way into the floor
    upright: float = 0.05  # most cosine between a wall below the lip and the floor
    alike: float = 0.95  # least cosine between the ways that wall and side look, along the floor
    near: float = 1.5  # [mm] of the wall from the side's uppermost place, which is a little below its rim


def no_walls(side: Contacts, faces: Sequence[Face], config: LipsConfig = LipsConfig()) -> set[int]:
    """The ids of inferred faces that stand under the lip of an inferred `side`, over a floor that was felt."""
    normal = side.normals.mean(axis=0)
    found: set[int] = set()
    for floor in faces:
        if not _flat(floor) or not _felt(floor):
            continue
        up = _outward(floor)
        if float(normal @ up) > -config.overhang or float(normal @ up) < -1.0 + config.overhang:
            continue
        lip = side.points[int(np.argmax(side.points @ up))]
        level = normal - float(normal @ up) * up
        level = level / np.linalg.norm(level)
        for wall in faces:
            if not _flat(wall) or _felt(wall):
                continue
            way = _outward(wall)
            beside = abs(float((lip - wall.contacts.points.mean(axis=0)) @ way)) < config.near
            if beside and float(way @ level) > config.alike and abs(float(way @ up)) < config.upright:
                found.add(wall.id)
    return found


def _flat(face: Face) -> bool:
    return isinstance(face.fit, Fit) and isinstance(face.fit.shape, Plane)


def _felt(face: Face) -> bool:
    return bool((face.contacts.touch != NOT_FELT).any())


def _outward(face: Face) -> Floats:
    assert isinstance(face.fit, Fit)
    return np.asarray(face.fit.shape.direction * (1.0 if face.fit.convex else -1.0))
