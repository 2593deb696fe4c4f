"""Pictures of the flat faces that were felt, each turned so that a person sees it upright."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exploration.planning.known.mosaic import Lattice, Mosaic
from primitives.arrays import Floats
from primitives.evidence import NOT_FELT
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.pose import frame_along

_FEW = 3  # contacts, of which no face is drawn


@dataclass(frozen=True)
class FacePicture:
    """The picture of a face, and where that is."""

    anchor: Floats  # (3,) on it [mm]
    normal: Floats  # (3,) outward
    share: Floats  # (n, m) as in a picture; nan where it is not known
    step: float  # [mm]


def face_pictures(faces: Sequence[Face], mosaic: Mosaic, margin: float = 8.0) -> list[FacePicture]:
    """Of all flat faces that were felt, their longer sides along x, and so many mm round them."""
    found: list[FacePicture] = []
    for face in faces:
        felt = face.contacts.points[face.contacts.touch != NOT_FELT]
        if isinstance(face.fit, Fit) and face.fit.kind == "plane" and len(felt) > _FEW:
            shape = face.fit.shape
            normal = shape.direction if face.fit.convex else -shape.direction
            turn = frame_along(normal, _long_side(felt, frame_along(normal)))
            lattice = Lattice.over(felt, turn[:, :2], mosaic.config.step, margin)
            seen = mosaic.picture(shape.anchor, normal, lattice)
            if seen.known.any():
                share = np.where(seen.known, seen.share, np.nan)
                found.append(FacePicture(felt.mean(axis=0), normal, share, lattice.step))
    return found


def _long_side(places: Floats, turn: Floats) -> Floats:
    """(3,) the way of the longer side of the least box round (n, 3) places in the plane of x and y of a frame."""
    angles = np.deg2rad(np.arange(0.0, 180.0))
    ways = np.column_stack([np.cos(angles), np.sin(angles)])
    wide = np.ptp(places @ turn[:, :2] @ ways.T, axis=0)
    high = np.roll(wide, -90)  # of the way across each
    best = int(np.argmin(np.where(wide >= high, wide * high, np.inf)))
    return np.asarray(turn[:, :2] @ ways[best])
