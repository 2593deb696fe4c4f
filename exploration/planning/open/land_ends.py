"""Where a flat face goes on past all that its picture shows.

On a ring, a frame or a land between holes the pad tells few contacts, and what of them is open is soon given up.
Its picture says more: where it ends on the face, and not at a rim, the face goes on (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_dilation, distance_transform_edt, gaussian_filter, label

from exploration.planning.known.mosaic import Lattice, Mosaic, Picture
from primitives.arrays import Bools, Floats
from primitives.evidence import NOT_FELT
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.pose import frame_along


@dataclass(frozen=True)
class LandEndsConfig:
    """What is a land, and goes on."""

    contacts: int = 8  # of a face, at least
    margin: float = 25.0  # [mm] round these and all pads that lay on it, over which its picture is drawn
    share: float = 0.65  # of the face under the skin, from which a place is well on it,
    bare: float = 0.35  # and up to which it is off it
    smooth: float = 1.5  # [mm] over which the way out is taken
    wide: float = 2.0  # [mm] of an end, at least
    narrow: float = 13.0  # [mm] of all of it from a rim, at most: a wider face is open where no pad lay
    ahead: float = 3.5  # [mm] past it, where nothing is drawn yet,
    around: float = 2.0  # [mm] round that,
    drawn: float = 0.3  # but for this share


@dataclass(frozen=True)
class LandEnd:
    """The middle of where a picture ends on its face, and the way on."""

    point: Floats  # (3,) [mm]
    way: Floats  # (3,) in the face
    normal: Floats  # (3,) outward


def land_ends(
    faces: Sequence[Face], mosaic: Mosaic, config: LandEndsConfig = LandEndsConfig()
) -> list[LandEnd]:
    """Of all flat faces that were felt often enough to know how they lie."""
    found: list[LandEnd] = []
    for face in faces:
        felt = face.contacts.points[face.contacts.touch != NOT_FELT]
        if not isinstance(face.fit, Fit) or face.fit.kind != "plane" or len(felt) < config.contacts:
            continue
        shape = face.fit.shape
        normal = shape.direction if face.fit.convex else -shape.direction
        over = np.concatenate([felt, mosaic.pictured(shape.anchor, normal)])
        lattice = Lattice.over(over, frame_along(normal)[:, :2], mosaic.config.step, config.margin)
        height = float(shape.anchor @ normal) * normal
        for at, way in _ends(mosaic.picture(shape.anchor, normal, lattice), lattice, config):
            found.append(LandEnd(height + lattice.along @ at, lattice.along @ way, normal))
    return found


def _ends(seen: Picture, lattice: Lattice, config: LandEndsConfig) -> list[tuple[Floats, Floats]]:
    """(2,) places on a lattice's axes, each with the (2,) way on."""
    off = seen.known & (seen.share < config.bare)
    if not off.any():
        return []
    border = seen.known & (seen.share > config.share) & binary_dilation(~seen.known)
    pieces, count = label(border, np.ones((3, 3)))
    if count == 0:
        return []
    to_rim = distance_transform_edt(~off) * lattice.step
    down, right = np.gradient(gaussian_filter(seen.known.astype(float), config.smooth / lattice.step))
    ends: list[tuple[Floats, Floats]] = []
    for number in range(1, count + 1):
        own = pieces == number
        places = lattice.origin + lattice.step * np.argwhere(own)
        way, at = -np.array([down[own].mean(), right[own].mean()]), places.mean(axis=0)
        length = float(np.linalg.norm(way))
        if length == 0.0 or np.ptp(places, axis=0).max() < config.wide or to_rim[own].max() > config.narrow:
            continue
        if not _drawn(seen.known, lattice, at + config.ahead * way / length, config):
            ends.append((at, way / length))
    return ends


def _drawn(known: Bools, lattice: Lattice, at: Floats, config: LandEndsConfig) -> bool:
    """Whether a picture shows what is round a (2,) place."""
    middle = np.round((at - lattice.origin) / lattice.step).astype(int)
    reach = int(config.around / lattice.step)
    low, high = np.maximum(middle - reach, 0), np.maximum(middle + reach + 1, 0)
    beside = known[low[0] : high[0], low[1] : high[1]]
    return bool(beside.size) and float(beside.mean()) > config.drawn
