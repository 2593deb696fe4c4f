"""Whether nothing but one flat face was felt: all normals are alike, or, where none were felt, all lie in a plane.

Contacts from anywhere hardly ever do so: of no body does much more than half of the surface face one way, and few
sections of one are planes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from primitives.arrays import Bools, Floats
from recognition.matching.contact_pairs import PARALLEL, of_one_face

MANY = 6  # contacts that hardly ever lie on one face if they came from anywhere
_THIN = 0.08  # of the contacts' second widest extent: how far they may lie off a plane, in root mean squares,
_NOISY = 1.5  # and sigmas, where that is more, but the face still
_BROAD = 4.0  # times as broad


@dataclass(frozen=True)
class LoneFace:
    """What lies on one flat face: the contact in the midst of all, and which way the face looks."""

    point: Floats  # (3,) [mm]
    facing: Floats  # (3,) unit
    signed: bool  # whether it is known which side is out


def lone_face(points: Floats, normals: Floats, felt: Bools, sigma: float = 0.0) -> LoneFace | None:
    """Of (n, 3) points [mm], and their normals where they were `felt`; None where there is more than one face.

    `sigma` [mm] is that of the points along the normal, where it is known.
    """
    if len(points) < MANY:
        return None
    middle = points[int(np.argmin(np.linalg.norm(points - np.median(points, axis=0), axis=1)))]
    if felt.all():
        return LoneFace(middle, _mean(normals), True) if of_one_face(normals, felt) else None
    _, extents, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    most = max(_THIN * extents[1], min(_NOISY * sigma * float(np.sqrt(len(points))), extents[1] / _BROAD))
    if not extents[2] < most:
        return None
    across = axes[2]
    if not felt.any():
        return LoneFace(middle, across, False)
    mean = _mean(normals[felt])
    alike = of_one_face(normals[felt], felt[felt]) and abs(float(mean @ across)) > np.cos(PARALLEL)
    return LoneFace(middle, mean, True) if alike else None


def _mean(normals: Floats) -> Floats:
    mean = normals.mean(axis=0)
    return np.asarray(mean / max(float(np.linalg.norm(mean)), 1e-12))
