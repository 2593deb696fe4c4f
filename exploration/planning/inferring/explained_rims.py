"""Which rims a face explains that is known by now, so that no wall is to be inferred below them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from exploration.control.sighting import Sighting
from exploration.planning.touching.findings import SeenRim
from primitives.arrays import Floats
from primitives.evidence import NOT_FELT
from primitives.fit import Fit
from primitives.patch_graph import Face

_ALONG = 0.5  # most cosine between a rim and the way that the face behind it looks
_LEANS = 0.12  # least cosine between the way out of a rim and the way that the face behind it looks
_ALIKE = 0.95  # least cosine between two directions that are one
_BEHIND = 1.0  # [mm] from a rim, within which the face behind it passes
_BEVEL = 3.0  # [mm] short of a flat face, within which the rim of a bevel is
_GAP = 3.0  # [mm] from where a flat face begins to where it is felt, mostly
_BESIDE = 16.0  # [mm] from a rim, within which a face was felt that goes on from it
_FAR = 12.0  # [mm] from a rim, within which an inferred face is known


def unexplained(rims: Sequence[SeenRim], faces: Sequence[Face]) -> list[SeenRim]:
    """The rims that no face is known behind."""
    return [rim for rim in rims if not _explained(rim, faces)]


def _explained(rim: SeenRim, faces: Sequence[Face]) -> bool:
    """Whether a face is known by now that passes behind a rim and along it: at its end another may pass, too.

    Where a flat face goes over into a round one there is no rim, but a pad that lies on both sees one.  The other
    flange of a spool is on the same cylinder, and goes on from no rim of the first.
    """
    seen, own = rim
    for face in faces:
        if face.id != own and isinstance(face.fit, Fit):
            at, side = seen.point[None], 1.0 if face.fit.convex else -1.0
            normal = side * face.fit.shape.normals(at)[0]
            behind = -side * float(face.fit.shape.signed_distance(at)[0])
            along = normal @ seen.outward > _LEANS and abs(float(normal @ seen.tangent)) < _ALONG
            bends = face.fit.kind != "plane" and float(normal @ seen.normal) > _ALIKE
            bends = bends and _beside(face.contacts.points, seen)
            if abs(behind) < _BEHIND and (bends or (along and _reaches(face, seen))):
                return True
            short = face.fit.kind == "plane" and float(normal @ seen.outward) > _ALIKE
            if short and _BEHIND <= behind < _BEVEL and _bevels(_felt(face), seen, behind):
                return True
    return False


def _felt(face: Face) -> Floats:
    return np.asarray(face.contacts.points[face.contacts.touch != NOT_FELT])


def _bevels(felt: Floats, rim: Sighting, short: float) -> bool:
    """Whether a bevel lies between a rim and a flat face `short` [mm] beyond it, felt up to about as far below it.

    A wall and a ledge in its place would be as low and as narrow.
    """
    near = felt[np.linalg.norm(felt - rim.point, axis=1) < _BESIDE]
    return float(((rim.point - near) @ rim.normal).min(initial=np.inf)) < short + _GAP


def _beside(points: Floats, rim: Sighting) -> bool:
    return float(np.linalg.norm(points - rim.point, axis=1).min(initial=np.inf)) < _BESIDE


def _reaches(face: Face, rim: Sighting) -> bool:
    """Whether a face goes on to a rim: one that is only inferred may be known at its other end alone."""
    if len(_felt(face)):
        return True
    away = face.contacts.points - rim.point
    beside = away @ rim.tangent
    on_both_hands = bool(beside.min() < 0.0 < beside.max())
    return on_both_hands or float(np.linalg.norm(away, axis=1).min(initial=np.inf)) < _FAR
