"""A smooth body through all that was felt, where faces tell too little of it: a mesh, and marked as one.

An egg, a grip or a gourd has no face that is a plane, a cylinder, a cone, a sphere or a torus.  What is bounded by
such ones then lies off most contacts, and their hull lies off those in hollows.  A smooth surface through contacts
and their normals (`primitives.implicit_surface`) is held against contacts that it was not made of: whole touches
are kept apart, and it is taken where it lies much nearer these than the body of faces.  Of faces that nothing
reaches past, as the bottom of what stands on one, and of round holes, the exact surfaces are kept.  Ours.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree
from scipy.special import ndtri

from models.csg import Cube, Polyhedron
from models.solid import TOLERANCE, Solid
from primitives.arrays import Bools, Floats
from primitives.errors import PalpateError
from primitives.evidence import NOT_FELT, Contacts
from primitives.pose import frame_along, pose
from primitives.shapes import Plane, Shape
from primitives.touch_errors import fits_of_touches
from recognition.assembly import Assembly, NotClosed
from recognition.assembly.bored import bored, is_hole
from recognition.assembly.given import FittedFace, outward
from recognition.assembly.made import Body
from recognition.assembly.piece import Piece, tree_of
from recognition.assembly.regularities import regularize
from recognition.hulled import hull_of
from recognition.smooth_mesh import smooth_mesh, through

_SHARE, _NEARLY = 75.0, 95.0  # per cent of the contacts, whose distance speaks for all; and nearly all
_NEAR = 0.12  # [mm] from a body, from which it is looked for
_BETTER = 0.5  # times the distance from the body, as which contacts kept apart must be nearer
_GENERAL, _LITTLE = 1.5, 0.1  # times the distance of its own contacts, and [mm] more, that they may be
_BENT = 0.01  # times the width of the gaps that contacts are kept apart of, and as much more
_LEAST = 60  # contacts with normals
_FEWER = 500  # contacts that it is made of, where some are kept apart
_FOLDS = 4  # lots that contacts are parted in, each kept apart once
_BULGE, _LEVEL = 0.25, 0.5  # times the spacing of contacts, and [mm] more, that it may bulge past their hull
_BULGED = 0.1  # share of its surface that may bulge farther
_ENDS = 4.0  # times the distance of most contacts from it, that nearly all are within
_FAR = 0.25  # of the longest side: what of the surface is farther from all contacts is a guess
_GUESSED = 0.05  # share of it that may be,
_HIDDEN = 0.5  # or where it stands on what nobody felt
_SUPPORT = 0.3  # [mm] past a face that nothing reaches past
_FEW = 0.005  # share of the contacts that may
_FLAT, _FLAT_SHARE = 3, 0.01  # touches of such a face, and share of the contacts, at least
_MOSTLY_ROUND = 0.25  # share of contacts on flat faces, of what is mostly round
_CELLS = 6  # along the longest side, at least, that a cloud is parted in, and two along the shortest

_TOLD = "what was felt bends as no face that has a name; the body is a smooth mesh through all contacts"


def freeform(
    faces: Sequence[FittedFace],
    contacts: Contacts,
    body: Assembly | NotClosed,
    free: Floats | None = None,
    is_hull: bool = False,
) -> Assembly | None:
    """The smooth body, where contacts kept apart tell that it is much nearer; None where the body is to be kept.

    The body may be the hull of all contacts: then one of the same contacts is to lie nearer those kept apart.
    Nothing is at (n, 3) places `free` [mm].
    """
    felt = contacts.select(contacts.touch != NOT_FELT)
    flat = _flat(faces, felt)
    ground = [k for k, face in enumerate(faces) if _is_ground(face) and _supports(face, felt.points)]
    rest = _beside(flat, faces, felt)
    smooth = rest.select(rest.has_normal)
    if len(smooth) < _LEAST or (off := _off(body, smooth, is_hull)) is None:
        return None
    room = np.concatenate([felt.points, *(_foot(faces[k].fit.shape, felt.points) for k in ground)])
    try:
        mesh = smooth_mesh(smooth, room, felt.points[_of_faces(felt, [faces[k] for k in flat])], free)
        made = None if mesh is None else _cut(mesh, faces, flat + ground, felt.points)
    except PalpateError:
        return None
    if made is None or not _is_among(made.solid, room):
        return None
    near, nearly = np.percentile(np.abs(made.solid.signed_distance(rest.points)), (_SHARE, _NEARLY))
    guessed = unfelt(made.solid, felt.points, _FAR * float(np.ptp(felt.points, axis=0).max()))
    most = max(off, _NEAR)
    if near > most or nearly > _ENDS * most or guessed > (_HIDDEN if ground else _GUESSED):
        return None
    sigma = max(off, float(near)) / float(ndtri(0.5 + 0.005 * _SHARE))
    told = [f"{_TOLD}, known to {sigma:.2f} mm (1 sigma)"]
    told += [f"{guessed:.0%} of its surface is a guess: no contact is near"] if guessed > _GUESSED else []
    return replace(made, warnings=(*told, *made.warnings), mesh_sigma=sigma)


def bends(faces: Sequence[FittedFace], contacts: Contacts) -> bool:
    """Whether a smooth surface tells contacts kept apart, most of which round faces share."""
    felt = contacts.select(contacts.touch != NOT_FELT)
    rest = _beside(_flat(faces, felt), faces, felt)
    flat = _of_faces(rest, [face for face in faces if face.fit.kind == "plane"])
    smooth = rest.select(rest.has_normal)
    if len(smooth) < _LEAST or flat.mean() > _MOSTLY_ROUND:
        return False
    return _off(NotClosed("not asked"), smooth, False) is not None


def _flat(faces: Sequence[FittedFace], felt: Contacts) -> list[int]:
    """The flat faces that a smooth body may end at."""
    return [k for k, face in enumerate(faces) if _is_flat(face, len(felt)) and _supports(face, felt.points)]


def _beside(flat: Sequence[int], faces: Sequence[FittedFace], felt: Contacts) -> Contacts:
    """The contacts of neither the flat faces nor round holes."""
    holes = [k for k, face in enumerate(faces) if is_hole(face.fit.shape, face)]
    return felt.select(~_of_faces(felt, [faces[k] for k in (*flat, *holes)]))


def _off(body: Assembly | NotClosed, smooth: Contacts, is_hull: bool) -> float | None:
    """[mm] that most contacts kept apart lie off the smooth surface, at most; None where that is too far."""
    if not is_hull and _away(body, smooth.points) < _NEAR:
        return None
    off, own, hull_off = [], [], []
    folds, wide = _folds(smooth)
    for apart in folds:
        kept = smooth.select(~apart)
        try:
            tried = through(kept, _FEWER)
        except PalpateError:
            return None
        off.append(np.abs(tried.values(smooth.points[apart])))
        own.append(np.abs(tried.values(kept.points)))
        if is_hull and (hull := hull_of(kept.points)) is not None:
            hull_off.append(np.abs(Solid.from_csg(hull).signed_distance(smooth.points[apart])))
    if not off:
        return None
    found = _most(np.concatenate(off))
    if hull_off:
        most = _most(np.concatenate(hull_off))
    else:
        fitted = _most(np.concatenate(own))
        most = min(_GENERAL * fitted + _LITTLE + _BENT * wide, _BETTER * _away(body, smooth.points))
    return found if found < most else None


def _cut(mesh: Solid, faces: Sequence[FittedFace], flat: Sequence[int], felt: Floats) -> Assembly:
    """A smooth body less what is past flat faces, and less the round holes; (n, 3) places were `felt`."""
    fits = tuple(outward(fit) for fit in fits_of_touches(faces))
    shapes = regularize(fits)
    leaf = Polyhedron(tuple(map(tuple, mesh.vertices.tolist())), tuple(map(tuple, mesh.triangles.tolist())))
    piece = Piece("mesh", "add", leaf, np.eye(4), None, ())
    made = Body((piece,), Solid.from_csg(piece.placed), TOLERANCE)
    for k in flat:
        made = made.less(_beyond(k, shapes.shapes[k], mesh)) or made
    made = bored(made, faces, shapes.shapes, felt)
    on = {i for cut in made.pieces for i in cut.surfaces}
    speaker = tuple(i if i in on else None for i in range(len(fits)))
    told = tuple(cut.why for cut in made.pieces if cut.why)
    return Assembly(fits, shapes, speaker, made.pieces, tree_of(made.pieces), made.solid, told)


def unfelt(body: Solid, felt: Floats, near: float) -> float:
    """Share of a body's surface that is farther than `near` [mm] from all (n, 3) felt places."""
    middles, areas = body.vertices[body.triangles].mean(axis=1), body.body.triangle_areas
    return float(areas[cKDTree(felt).query(middles)[0] > near].sum() / areas.sum())


def _away(body: Assembly | NotClosed, points: Floats) -> float:
    """[mm] from a body, within which most of (n, 3) points are; without end where there is none."""
    if isinstance(body, NotClosed):
        return np.inf
    return _most(np.abs(body.solid.signed_distance(points)))


def _most(off: Floats) -> float:
    """[mm] within which most of (n,) distances are."""
    return float(np.percentile(off, _SHARE))


def _is_flat(face: FittedFace, count: int) -> bool:
    """Whether it was felt to be flat, by some touches and some of all contacts: one pad lies flat on any bulge."""
    touch = face.contacts.touch[face.contacts.touch != NOT_FELT]
    return face.fit.kind == "plane" and len(np.unique(touch)) >= _FLAT and len(touch) > _FLAT_SHARE * count


def _is_ground(face: FittedFace) -> bool:
    """Whether it is a flat face that nobody felt, as what lies on a table."""
    return face.fit.kind == "plane" and not (face.contacts.touch != NOT_FELT).any()


def _supports(face: FittedFace, felt: Floats) -> bool:
    """Whether no more than strays of (n, 3) felt places reach past a flat face."""
    past = (felt - face.fit.shape.anchor) @ face.fit.shape.direction
    return bool(np.mean(past > _SUPPORT) < _FEW)


def _foot(plane: Shape, felt: Floats) -> Floats:
    """(n, 3) where (n, 3) places stand on a plane."""
    return felt - np.outer((felt - plane.anchor) @ plane.direction, plane.direction)


def _of_faces(felt: Contacts, faces: Sequence[FittedFace]) -> Bools:
    """(n,) which contacts are those of faces."""
    own = {place.tobytes() for face in faces for place in face.contacts.points}
    return np.array([place.tobytes() in own for place in felt.points], dtype=np.bool_)


def _folds(felt: Contacts) -> tuple[list[Bools], float]:
    """(n,) which contacts are kept apart, a few times, and the width of the gaps that this leaves [mm].

    Whole touches are, which leave none; of a cloud, what lies in some cells.
    """
    names, lot = np.unique(felt.touch, return_inverse=True)
    size = 0.0
    if not 2 * _FOLDS <= len(names) < len(felt):
        own = felt.points - felt.points.mean(axis=0)
        sides = np.ptp(own @ np.linalg.svd(own, full_matrices=False)[2].T, axis=0)
        size = max(min(float(sides.max()) / _CELLS, 0.5 * float(sides.min())), 1e-9)
        lot = np.unique(np.floor(own / size), axis=0, return_inverse=True)[1].reshape(-1)
    folds = [np.asarray(lot % _FOLDS == k) for k in range(_FOLDS)]
    return [fold for fold in folds if fold.any() and not fold.all()], size


def _is_among(body: Solid, room: Floats) -> bool:
    """Whether a body lies among (n, 3) places, and bulges no farther past their hull than between some of them."""
    hull = hull_of(room)
    if hull is None:
        return False
    middles, areas = body.vertices[body.triangles].mean(axis=1), body.body.triangle_areas
    past = Solid.from_csg(hull).signed_distance(middles)
    most = _BULGE * float(np.sqrt(areas.sum() / len(room))) + _LEVEL
    return bool(areas[past > most].sum() < _BULGED * areas.sum())


def _beyond(number: int, plane: Shape, mesh: Solid) -> Piece:
    """What takes away all past a flat face."""
    assert isinstance(plane, Plane)
    wide = 2.0 * float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    middle = mesh.vertices.mean(axis=0)
    foot = middle - float((middle - plane.origin) @ plane.normal) * plane.normal
    where = pose(frame_along(plane.normal), foot + 0.5 * wide * plane.normal)
    return Piece(
        "cube", "subtract", Cube((wide, wide, wide)), where, None, ((None, None),) * 2 + ((number, None),)
    )
