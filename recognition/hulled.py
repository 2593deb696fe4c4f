"""The hull of all that was felt: the body where faces tell too little of it.

Most of an object of facets, folds or freeform surface may be felt, and name no face; the few that it names bound a
body that most contacts lie off, or one in pieces with nothing under many of them.  Then their convex hull is
nearer to the object, less its round holes and what an array passed through.  Where there are none, the facets of
the hull are read as those of any mesh: what bends smoothly is freeform.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import ConvexHull, Delaunay, QhullError, cKDTree

from models.csg import Polyhedron
from models.solid import TOLERANCE, Solid
from primitives.arrays import Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.touch_errors import fits_of_touches
from recognition.assembly import Assembly, NotClosed
from recognition.assembly.bored import bored
from recognition.assembly.given import FittedFace, outward
from recognition.assembly.hollowed import hollowed
from recognition.assembly.made import Body, Known
from recognition.assembly.piece import Piece, tree_of
from recognition.assembly.regularities import regularize

_OFF = 1.0  # [mm] from the body, from which a contact is not on it
MOST = 0.4  # share of the contacts off the body, from which another is looked for
_IN_AIR = 2.0  # [mm] outside the body, from which a contact has nothing under it
_LACKS = 0.025  # share of the contacts with nothing under them, likewise, where the body is in pieces
_FULL = 0.15  # share of a hull that may be empty, where the body lacks that much
BETTER = 0.75  # of that share, as which less must be off the other
_STRAYING = 0.01  # share of the contacts that may be off a hull that all others lie on
_LEAST = 30  # contacts
_EMPTY = 0.25  # share of a hull, of which more is known to be empty, that is no body
_BESIDE = 3.0  # [mm] from a place known to be empty, that is so too
_SAMPLES = 4000
_FLAT = 1e-6  # volume over area^(3/2), of which less is no body
_COARSE = 40  # places along the longest side of the hull that are told apart

_LACKING = "the faces leave much of what was felt in the air; the body is the hull of all contacts"
_TOLD = "most of what was felt lies on no face that was recognized; the body is the hull of all contacts"


def hulled(
    faces: Sequence[FittedFace], contacts: Contacts, body: Assembly | NotClosed, free: Floats | None = None
) -> Assembly | None:
    """The hull, where contacts are on it that are off the body; None where the body is to be kept.

    It is, too, where much of the hull is empty: (n, 3) places `free` are.
    """
    felt = contacts.points[contacts.touch != NOT_FELT]
    before, lacks = off_body(body, felt), _in_pieces(body) and in_air(body, felt) > _LACKS
    if len(felt) < _LEAST or not faces or (before < MOST and not lacks):
        return None
    hull = hull_of(felt)
    if hull is None or _emptied(np.array(hull.points), free) > (_FULL if lacks else _EMPTY):
        return None
    fits = tuple(outward(fit) for fit in fits_of_touches(faces))
    regularized = regularize(fits)
    places = [face.contacts.points[face.contacts.touch != NOT_FELT] for face in faces]
    known = Known(regularized.shapes, places, [False] * len(fits), felt[:0])
    piece = Piece("polyhedron", "add", hull, np.eye(4), None, ())
    whole = Body((piece,), Solid.from_csg(piece.placed), TOLERANCE)
    less = hollowed(bored(whole, faces, regularized.shapes, felt), free, known)
    solid = Solid.from_mesh(hull.points, hull.faces) if len(less.pieces) == 1 else less.solid
    on = {i for cut in less.pieces for i in cut.surfaces}
    speaker = tuple(i if i in on else None for i in range(len(fits)))
    told = (_LACKING if lacks else _TOLD, *(cut.why for cut in less.pieces[1:]))
    made = Assembly(fits, regularized, speaker, less.pieces, tree_of(less.pieces), solid, told)
    nearer = in_air(made, felt) < in_air(body, felt) if lacks else off_body(made, felt) < BETTER * before
    return made if nearer else None


def all_on_hull(felt: Floats) -> bool:
    """Whether nearly all of (n, 3) felt places lie on their hull, as those of a convex object do."""
    hull = hull_of(felt) if len(felt) >= _LEAST else None
    if hull is None:
        return False
    away = Solid.from_csg(hull).signed_distance(felt)
    return bool(np.mean(np.abs(away) > _OFF) < _STRAYING)


def off_body(body: Assembly | NotClosed, felt: Floats) -> float:
    """Share of (n, 3) felt places that are not on a body."""
    if isinstance(body, NotClosed) or not len(felt):
        return 1.0
    return float(np.mean(np.abs(body.solid.signed_distance(felt)) > _OFF))


def mean_distance(body: Assembly | NotClosed, felt: Floats) -> float:
    """[mm] of (n, 3) felt places from a body; without end where there is none."""
    if isinstance(body, NotClosed) or not len(felt):
        return np.inf
    return float(np.mean(np.abs(body.solid.signed_distance(felt))))


def _in_pieces(body: Assembly | NotClosed) -> bool:
    """Whether a body is several, as no object is that can be held."""
    return not isinstance(body, NotClosed) and body.solid.parts > 1


def in_air(body: Assembly | NotClosed, felt: Floats) -> float:
    """Share of (n, 3) felt places that a body has nothing under."""
    if isinstance(body, NotClosed) or not len(felt):
        return 0.0
    return float(np.mean(body.solid.signed_distance(felt) > _IN_AIR))


def _emptied(corners: Floats, free: Floats | None) -> float:
    """Share of the hull of (n, 3) corners that lies beside (m, 3) places which hold nothing."""
    if free is None or not len(free):
        return 0.0
    low, high = corners.min(axis=0), corners.max(axis=0)
    some = low + (high - low) * np.random.default_rng(0).random((_SAMPLES, 3))
    some = some[Delaunay(corners).find_simplex(some) >= 0]
    return float(np.mean(cKDTree(free).query(some)[0] < _BESIDE)) if len(some) else 0.0


def hull_of(felt: Floats) -> Polyhedron | None:
    """Of the outermost of the places that a coarse grid tells apart."""
    try:
        corners = felt[ConvexHull(felt).vertices]
        cell = float(np.ptp(corners, axis=0).max()) / _COARSE
        _, first = np.unique(np.round(corners / cell), axis=0, return_index=True)
        some = corners[np.sort(first)]
        found = ConvexHull(some)
        if found.volume < _FLAT * found.area**1.5:
            return None
    except (QhullError, ValueError):
        return None
    middle, faces = some.mean(axis=0), []
    for a, b, c in found.simplices.tolist():
        out = float(np.cross(some[b] - some[a], some[c] - some[a]) @ (some[a] - middle))
        faces.append((a, b, c) if out > 0.0 else (a, c, b))
    return Polyhedron(tuple(map(tuple, some.tolist())), tuple(faces))
