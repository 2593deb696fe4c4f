"""Places at a face's rim -> the edge that they lie along, as if it had been seen from the face."""

from __future__ import annotations

import numpy as np

from exploration.control.sighting import Sighting
from primitives.arrays import Bools, Floats
from primitives.pose import cross
from primitives.shapes import Shape

_STRAIGHT = 15.0  # [mm] on either side of a rim's middle, over which it is taken for straight
_SLENDER = 4.0  # times as long as wide, from which places of a rim make a line
_AGREES = 0.9  # least cosine of the way out of that line with what its places say


def rim_sighting(shape: Shape, side: float, at: Floats, out: Floats) -> Sighting:
    """The edge of a face along (n, 3) touched places `at` its rim, with the (n, 3) ways `out` of the face.

    The face's outward normals are `side` times those of its shape.
    """
    point: Floats = at[int(np.argmin(np.linalg.norm(at - at.mean(axis=0), axis=1)))]
    normal = side * shape.normals(point[None])[0]
    outward = out.mean(axis=0)
    outward = outward - (outward @ normal) * normal
    outward = outward / np.linalg.norm(outward)
    beside = at[np.linalg.norm(at - point, axis=1) < _STRAIGHT]
    away = beside - beside.mean(axis=0)
    _, spread, ways = np.linalg.svd(away - np.outer(away @ normal, normal), full_matrices=False)
    across = cross(ways[0], normal)
    across = across * np.sign(across @ outward)
    long = len(away) > 2 and spread[0] > _SLENDER * spread[1] and float(np.ptp(away @ ways[0])) > _STRAIGHT
    if long and across @ outward > _AGREES:  # a line knows the way out better than its places do
        outward = across
    tangent = cross(normal, outward)
    return Sighting(point + outward, tangent, outward, normal, 1.0, float(np.ptp(at @ tangent)))


def by_heading(out: Floats) -> list[Bools]:
    """Masks of the ways out that look alike: a rim that turns is several."""
    left, parts = np.ones(len(out), dtype=bool), []
    while left.any():
        first = out[np.flatnonzero(left)[0]]
        part = left & (out @ first > 0.7)
        parts.append(part)
        left &= ~part
    return parts
