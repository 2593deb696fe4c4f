"""The hull of all that was felt: the body where faces tell too little of it.

Most of an object of facets, folds or freeform surface may be felt, and name no face; the few that it names bound a
body that most contacts lie off.  Then their convex hull is nearer to the object.  No side of it was measured.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import ConvexHull, Delaunay, QhullError, cKDTree

from models.csg import Polyhedron
from models.solid import Solid
from primitives.arrays import Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.shared_error import with_shared_error
from recognition.assembly import Assembly, NotClosed
from recognition.assembly.assemble import FittedFace, outward
from recognition.assembly.piece import Piece
from recognition.assembly.regularities import regularize

_OFF = 1.0  # [mm] from the body, from which a contact is not on it
MOST = 0.4  # share of the contacts off the body, from which another is looked for
BETTER = 0.75  # of that share, as which less must be off the other
_LEAST = 30  # contacts
_EMPTY = 0.25  # share of a hull, of which more is known to be empty, that is no body
_BESIDE = 3.0  # [mm] from a place known to be empty, that is so too
_SAMPLES = 4000
_COARSE = 40  # places along the longest side of the hull that are told apart

_TOLD = "most of what was felt lies on no face that was recognized; the body is the hull of all contacts"


def hulled(
    faces: Sequence[FittedFace], contacts: Contacts, body: Assembly | NotClosed, free: Floats | None = None
) -> Assembly | None:
    """The hull, where contacts are on it that are off the body; None where the body is to be kept.

    It is, too, where much of the hull is empty: (n, 3) places `free` are.
    """
    felt = contacts.points[contacts.touch != NOT_FELT]
    before = off_body(body, felt)
    if len(felt) < _LEAST or not faces or before < MOST:
        return None
    hull = _hull(felt)
    if hull is None or _emptied(np.array(hull.points), free) > _EMPTY:
        return None
    piece = Piece("polyhedron", "add", hull, np.eye(4), None, ())
    fits = tuple(outward(with_shared_error(face.fit, face.contacts)) for face in faces)
    none = tuple(None for _ in fits)
    solid = Solid.from_csg(piece.placed)
    made = Assembly(fits, regularize(fits), none, (piece,), piece.placed, solid, (_TOLD,))
    return made if off_body(made, felt) < BETTER * before else None


def off_body(body: Assembly | NotClosed, felt: Floats) -> float:
    """Share of (n, 3) felt places that are not on a body."""
    if isinstance(body, NotClosed) or not len(felt):
        return 1.0
    return float(np.mean(np.abs(body.solid.signed_distance(felt)) > _OFF))


def _emptied(corners: Floats, free: Floats | None) -> float:
    """Share of the hull of (n, 3) corners that lies beside (m, 3) places which hold nothing."""
    if free is None or not len(free):
        return 0.0
    low, high = corners.min(axis=0), corners.max(axis=0)
    some = low + (high - low) * np.random.default_rng(0).random((_SAMPLES, 3))
    some = some[Delaunay(corners).find_simplex(some) >= 0]
    return float(np.mean(cKDTree(free).query(some)[0] < _BESIDE)) if len(some) else 0.0


def _hull(felt: Floats) -> Polyhedron | None:
    """Of the outermost of the places that a coarse grid tells apart."""
    try:
        corners = felt[ConvexHull(felt).vertices]
        cell = float(np.ptp(corners, axis=0).max()) / _COARSE
        _, first = np.unique(np.round(corners / cell), axis=0, return_index=True)
        some = corners[np.sort(first)]
        found = ConvexHull(some)
    except (QhullError, ValueError):
        return None
    middle, faces = some.mean(axis=0), []
    for a, b, c in found.simplices.tolist():
        out = float(np.cross(some[b] - some[a], some[c] - some[a]) @ (some[a] - middle))
        faces.append((a, b, c) if out > 0.0 else (a, c, b))
    return Polyhedron(tuple(map(tuple, some.tolist())), tuple(faces))
