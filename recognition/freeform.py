"""A smooth body through all that was felt, where faces tell too little of it: a mesh, and marked as one.

An egg, a grip or a gourd has no face that is a plane, a cylinder, a cone, a sphere or a torus.  What is bounded by
such ones then lies off most contacts, and their hull lies off those in hollows.  A smooth surface through contacts
and their normals (`primitives.implicit_surface`) is held against contacts that it was not made of: whole touches
are kept apart, and it is taken where it lies nearer these than the body of faces.  Of faces that nothing
reaches past, as the bottom of what stands on one, and of round holes, the exact surfaces are kept.  Ours.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

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
from recognition.kept_apart import FEWEST, NEAR, NEARLY, SHARE, SIGMAS, kept_apart, most_of
from recognition.smooth_mesh import smooth_mesh

_BULGE, _LEVEL = 0.25, 0.5  # times the spacing of contacts, and [mm] more, that it may bulge past their hull
_OUTSIDE = 1.5  # times what contacts kept apart are past it, who are few
_BULGED = 0.1  # share of its surface that may bulge farther
_ENDS = 4.0  # times the distance of most contacts from it, that nearly all are within
_FAR = 0.25  # of the longest side: what of the surface is farther from all contacts is a guess
_GUESSED, _SPARSE = 0.05, 0.25  # share of it that may be, and of a cloud,
_HIDDEN = 0.5  # or where it stands on what nobody felt
_SUPPORT = 0.3  # [mm] past a face that nothing reaches past
_FEW = 0.005  # share of the contacts that may
_FLAT, _FLAT_SHARE = 3, 0.01  # touches of such a face, and share of the contacts, at least
_WIDE = 20.0  # [mm] both ways, of what is flat although fewer touched it
_REST = 0.12  # share of contacts beside those, of which a smooth body is made where faces closed one
_MOSTLY_ROUND = 0.25  # share of contacts on flat faces, of what is mostly round

_TOLD = "what was felt bends as no face that has a name; the body is a smooth mesh through all contacts"


def freeform(
    faces: Sequence[FittedFace],
    contacts: Contacts,
    body: Assembly | NotClosed,
    free: Floats | None = None,
    is_hull: bool = False,
) -> Assembly | None:
    """The smooth body, where contacts kept apart tell that it is nearer; None where the body is to be kept.

    The body may be the hull of all contacts: then one of the same contacts is to lie nearer those kept apart.
    Nothing is at (n, 3) places `free` [mm].
    """
    felt = contacts.select(contacts.touch != NOT_FELT)
    flat = _flat(faces, felt)
    ground = [k for k, face in enumerate(faces) if _is_ground(face) and _supports(face, felt.points)]
    rest = _beside(flat, faces, felt)
    smooth = rest.select(rest.has_normal)
    mostly_flat = len(rest) < _REST * len(felt) and isinstance(body, Assembly) and not is_hull
    if len(smooth) < FEWEST or mostly_flat:
        return None
    if (apart := kept_apart(_away(body, smooth.points), _freedom(faces, felt), smooth, is_hull)) is None:
        return None
    room = np.concatenate([felt.points, *(_foot(faces[k].fit.shape, felt.points) for k in ground)])
    try:
        mesh = smooth_mesh(smooth, room, felt.points[_of_faces(felt, [faces[k] for k in flat])], free)
        made = None if mesh is None else _cut(mesh, faces, flat + ground, felt.points)
    except PalpateError:
        return None
    if made is None or not _is_among(made.solid, room, apart.outside):
        return None
    near, nearly = np.percentile(np.abs(made.solid.signed_distance(rest.points)), (SHARE, NEARLY))
    guessed = unfelt(made.solid, felt.points, _FAR * float(np.ptp(felt.points, axis=0).max()))
    most = max(apart.off, NEAR)
    may_be = _HIDDEN if ground else _SPARSE if apart.gap else _GUESSED
    if near > most or nearly > _ENDS * most or guessed > may_be:
        return None
    sigma = max(apart.off, float(near)) / SIGMAS
    told = [f"{_TOLD}, known to {sigma:.2f} mm (1 sigma)"]
    told += [f"{guessed:.0%} of its surface is a guess: no contact is near"] if guessed > _GUESSED else []
    return replace(made, warnings=(*told, *made.warnings), mesh_sigma=sigma)


def bends(faces: Sequence[FittedFace], contacts: Contacts) -> bool:
    """Whether a smooth surface tells contacts kept apart, most of which round faces share."""
    felt = contacts.select(contacts.touch != NOT_FELT)
    rest = _beside(_flat(faces, felt), faces, felt)
    flat = _of_faces(rest, [face for face in faces if face.fit.kind == "plane"])
    smooth = rest.select(rest.has_normal)
    if len(smooth) < FEWEST or flat.mean() > _MOSTLY_ROUND:
        return False
    return kept_apart(np.inf, 0.0, smooth, False) is not None


def _flat(faces: Sequence[FittedFace], felt: Contacts) -> list[int]:
    """The flat faces that a smooth body may end at."""
    return [k for k, face in enumerate(faces) if _is_flat(face, len(felt)) and _supports(face, felt.points)]


def _beside(flat: Sequence[int], faces: Sequence[FittedFace], felt: Contacts) -> Contacts:
    """The contacts of neither the flat faces nor round holes."""
    holes = [k for k, face in enumerate(faces) if is_hole(face.fit.shape, face)]
    return felt.select(~_of_faces(felt, [faces[k] for k in (*flat, *holes)]))


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


def _freedom(faces: Sequence[FittedFace], felt: Contacts) -> float:
    """Parameters of faces that were felt, for each contact."""
    own = [face.fit.shape.dof for face in faces if (face.contacts.touch != NOT_FELT).any()]
    return sum(own) / max(len(felt), 1)


def _away(body: Assembly | NotClosed, points: Floats) -> float:
    """[mm] from a body, within which most of (n, 3) points are; without end where there is none."""
    if isinstance(body, NotClosed):
        return np.inf
    return most_of(np.abs(body.solid.signed_distance(points)))


def _is_flat(face: FittedFace, count: int) -> bool:
    """Whether it was felt to be flat, by some of all contacts: by a few touches, or wider than a pad.

    One pad lies flat on any bulge.
    """
    felt = face.contacts.select(face.contacts.touch != NOT_FELT)
    if face.fit.kind != "plane" or len(felt) <= _FLAT_SHARE * count:
        return False
    across = felt.points @ face.fit.shape.frame[:, :2]
    return len(np.unique(felt.touch)) >= _FLAT or bool((np.ptp(across, axis=0) > _WIDE).all())


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


def _is_among(body: Solid, room: Floats, past: float) -> bool:
    """Whether a body lies among (n, 3) places, and bulges no farther past their hull than between some of them.

    Nor much farther than some of them, kept apart, were `past` [mm] the hull of the others.
    """
    hull = hull_of(room)
    if hull is None:
        return False
    middles, areas = body.vertices[body.triangles].mean(axis=1), body.body.triangle_areas
    bulge = Solid.from_csg(hull).signed_distance(middles)
    most = max(_BULGE * float(np.sqrt(areas.sum() / len(room))) + _LEVEL, _OUTSIDE * past)
    return bool(areas[bulge > most].sum() < _BULGED * areas.sum())


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
