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
import trimesh
from scipy.spatial import cKDTree
from scipy.special import ndtri

from models.body import LabeledSurface
from models.csg import Cube, Polyhedron
from models.solid import TOLERANCE, Solid
from primitives.arrays import Bools, Floats
from primitives.errors import PalpateError
from primitives.evidence import NOT_FELT, Contacts
from primitives.implicit_surface import ImplicitSurface, implicit_surface, spread
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

_SHARE = 75.0  # per cent of the contacts, whose distance from a body speaks for all
_NEAR = 0.12  # [mm] from a body, from which it is looked for
_BETTER = 0.5  # times the distance from the body, as which contacts kept apart must be nearer
_GENERAL, _LITTLE = 1.5, 0.1  # times the distance of its own contacts, and [mm] more, that they may be
_LEAST = 60  # contacts with normals
_FOLDS = 4  # lots that contacts are parted in, each kept apart once
_MOST = 800  # contacts that it is made of
_COARSE = 20_000  # contacts that these are chosen of
_SIGMA, _LEAN = 0.05, 0.02  # [mm] and [rad] that no contact is better than
_ROUND = 3.0  # [mm] round all contacts that it may reach
_STEPS = 40  # along the longest side
_SMOOTH = 0.08  # [mm] that corners of the mesh are moved by, to have fewer
_FARTHEST = 0.5  # [mm] that its corners are moved onto the surface
_BULGE = 0.1  # of its volume, that may lie outside the hull of all contacts
_FAR = 0.25  # of the longest side: what of the surface is farther from all contacts is a guess
_GUESSED = 0.05  # share of it that may be,
_HIDDEN = 0.5  # or where it stands on what nobody felt
_CRUMB = 0.02  # of the volume, that may lie in pieces apart
_AT_ONCE = 200  # empty places that lie inside, and places of flat faces outside, that are told at a time
_TOLD_AGAIN = 3  # times they are
_INSIDE = 1.0  # [mm] on the other side, that they are told to be
_SUPPORT = 0.3  # [mm] past a face that nothing reaches past
_FEW = 0.005  # share of the contacts that may
_FLAT = 3  # touches of such a face, at least

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
    felt = contacts.select((contacts.touch != NOT_FELT) & contacts.has_normal)
    flat = [k for k, face in enumerate(faces) if _is_flat(face) and _supports(face, felt.points)]
    ground = [k for k, face in enumerate(faces) if _is_ground(face) and _supports(face, felt.points)]
    sharp = flat + [k for k, face in enumerate(faces) if is_hole(face.fit.shape, face)]
    smooth = felt.select(~_of_faces(felt, [faces[k] for k in sharp]))
    if len(smooth) < _LEAST or (off := _off(body, smooth, is_hull)) is None:
        return None
    room = np.concatenate([felt.points, *(_foot(faces[k].fit.shape, felt.points) for k in ground)])
    try:
        mesh = _meshed(smooth, room, felt.points[_of_faces(felt, [faces[k] for k in flat])], free)
    except PalpateError:
        return None
    made = None if mesh is None else _cut(mesh, faces, flat + ground, felt.points)
    if made is None or not _is_among(made.solid, room):
        return None
    guessed = unfelt(made.solid, felt.points, _FAR * float(np.ptp(felt.points, axis=0).max()))
    if guessed > (_HIDDEN if ground else _GUESSED):
        return None
    sigma = off / float(ndtri(0.5 + 0.005 * _SHARE))
    told = [f"{_TOLD}, known to {sigma:.2f} mm (1 sigma)"]
    told += [f"{guessed:.0%} of its surface is a guess: no contact is near"] if guessed > _GUESSED else []
    return replace(made, warnings=(*told, *made.warnings), mesh_sigma=sigma)


def _off(body: Assembly | NotClosed, smooth: Contacts, is_hull: bool) -> float | None:
    """[mm] that most contacts kept apart lie off the smooth surface, at most; None where that is too far."""
    if not is_hull and _away(body, smooth.points) < _NEAR:
        return None
    off, own, hull_off = [], [], []
    for apart in _folds(smooth):
        kept = smooth.select(~apart)
        try:
            tried = _through(kept)
        except PalpateError:
            return None
        off.append(np.abs(tried.values(smooth.points[apart])))
        own.append(np.abs(tried.values(kept.points)))
        if is_hull and (hull := hull_of(kept.points)) is not None:
            hull_off.append(np.abs(Solid.from_csg(hull).signed_distance(smooth.points[apart])))
    if not off:
        return None
    found = float(np.percentile(np.concatenate(off), _SHARE))
    if hull_off:
        most = float(np.percentile(np.concatenate(hull_off), _SHARE))
    else:
        fitted = float(np.percentile(np.concatenate(own), _SHARE))
        most = min(_GENERAL * fitted + _LITTLE, _BETTER * _away(body, smooth.points))
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
    return Assembly(fits, shapes, speaker, made.pieces, tree_of(made.pieces), _marked(made.solid), told)


def unfelt(body: Solid, felt: Floats, near: float) -> float:
    """Share of a body's surface that is farther than `near` [mm] from all (n, 3) felt places."""
    middles, areas = body.vertices[body.triangles].mean(axis=1), body.body.triangle_areas
    return float(areas[cKDTree(felt).query(middles)[0] > near].sum() / areas.sum())


def _away(body: Assembly | NotClosed, points: Floats) -> float:
    """[mm] from a body, within which most of (n, 3) points are; without end where there is none."""
    if isinstance(body, NotClosed):
        return np.inf
    return float(np.percentile(np.abs(body.solid.signed_distance(points)), _SHARE))


def _is_flat(face: FittedFace) -> bool:
    """Whether it was felt to be flat: one pad lies flat on the top of any bulge; so it takes a few touches."""
    return face.fit.kind == "plane" and (np.unique(face.contacts.touch) != NOT_FELT).sum() >= _FLAT


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


def _folds(felt: Contacts) -> list[Bools]:
    """(n,) which contacts are kept apart, a few times: whole touches, or single ones where few are told."""
    names, touch = np.unique(felt.touch, return_inverse=True)
    lot = touch if len(names) >= 2 * _FOLDS else np.arange(len(felt))
    return [np.asarray(lot % _FOLDS == k) for k in range(_FOLDS)]


def _through(
    felt: Contacts, elsewhere: Floats | None = None, outside: Floats | None = None
) -> ImplicitSurface:
    """The surface through the contacts that are spread the widest."""
    rows = np.arange(len(felt))
    if len(rows) > _COARSE:
        rows = np.random.default_rng(0).permutation(len(rows))[:_COARSE]
    kept = felt.select(rows[spread(felt.points[rows], _MOST)])
    sigma, lean = np.maximum(kept.sigma, _SIGMA), np.maximum(kept.normal_sigma, _LEAN)
    return implicit_surface(kept.points, kept.normals, sigma, lean, elsewhere, outside)


def _meshed(smooth: Contacts, room: Floats, cut: Floats, free: Floats | None) -> Solid | None:
    """The body inside the surface through smooth contacts, within (n, 3) places; None where it is none.

    The faces that (m, 3) places lie on will `cut` it, and (k, 3) `free` ones are empty.
    """
    low, high = room.min(axis=0) - _ROUND, room.max(axis=0) + _ROUND
    sides = [(cut, -_INSIDE)] if free is None else [(cut, -_INSIDE), (free, _INSIDE)]
    surface, told, away = _through(smooth), [np.empty((0, 3))], [np.empty(0)]
    for _ in range(_TOLD_AGAIN):
        wrong = [(places[np.sign(side) * surface.values(places) < 0.0], side) for places, side in sides]
        for places, side in wrong:
            told.append(places[spread(places, _AT_ONCE)])
            away.append(np.full(len(told[-1]), side))
        if not any(len(places) for places, _ in wrong):
            break
        surface = _through(smooth, np.concatenate(told), np.concatenate(away))
    whole = _settled(Solid.from_field(surface.values, low, high, float((high - low).max()) / _STEPS), surface)
    whole = whole.simplified(_SMOOTH)
    largest = whole.largest_part()
    return largest if whole.volume - largest.volume < _CRUMB * largest.volume else None


def _settled(solid: Solid, surface: ImplicitSurface) -> Solid:
    """The same, its corners moved onto a surface that they lie near."""
    mesh = trimesh.Trimesh(solid.vertices, solid.triangles, process=False)
    away = np.clip(surface.values(solid.vertices), -_FARTHEST, _FARTHEST)
    return Solid.from_mesh(solid.vertices - away[:, None] * mesh.vertex_normals, solid.triangles)


def _is_among(body: Solid, room: Floats) -> bool:
    """Whether a body lies among (n, 3) places, and bulges little past them."""
    hull = hull_of(room)
    return hull is not None and body.volume - body.shared_volume(Solid.from_csg(hull)) < _BULGE * body.volume


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


def _marked(solid: Solid) -> Solid:
    """The same, the triangles of the mesh, its first leaf, standing for themselves: one freeform face."""
    others = [k for k, surface in enumerate(solid.surfaces) if surface.leaf != 0]
    place = np.zeros(len(solid.surfaces), dtype=np.int64)
    place[others] = np.arange(1, len(others) + 1)
    surfaces = (LabeledSurface(None, True, 0), *(solid.surfaces[k] for k in others))
    return Solid.from_labeled(solid.vertices, solid.triangles, place[solid.face_of_triangle], surfaces)
