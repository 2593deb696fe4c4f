"""Faces that were none: others' contacts lie in front of them, or their own all lie where two others meet.

A convex body lies behind each of its faces.  A pad that slides along a sharp rim feels something like a small
cone; every contact there lies on the two true faces at once.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np

from primitives.arrays import Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit, fit
from primitives.patch_graph import Face, PatchGraph
from primitives.shapes import Cylinder, Shape

_BEYOND = 0.3  # [mm] a contact this far in front of a face contradicts it
_PAST = 1.0  # [mm] past the end of its own narrow face, at which blurred rubber may put a contact
_SHARE = 0.1  # of a face's own contacts, that as many against it outweigh
_MOST = 3  # contradicting contacts that are put down to noise
_ON_EDGE = 0.25  # [mm] from two other faces, within which a contact lies on their edge
_POOR = 0.05  # [mm] rms, from which so few contacts as below are of no one face
_AGREE = 0.8  # share of a sound face's contacts that lie on it
_HOPELESS = 0.15  # [mm] rms, from which so few contacts lead nowhere while exploration goes on
_ROUND = 0.9  # cosine between two normals of a face, below which it surely bends
_TELLING = 5  # contacts that are surer than that, without which a face that has unsure ones is none
_FEW = 30  # contacts, below which a face may be a poor reading of a larger one
_SAME = 0.1  # [mm] from a larger face, within which more contacts than those are no face beside it
_LARGER = 1.5  # times as many contacts make a face the larger
_SHEET = 4.0  # [mm] of thickness at most
_ASTRIDE = 0.5  # [mm] past each of its sides, that no contact of its edge can lie
_NEAR = 15.0  # [mm] from a contact of each side
_SOUND = 10  # contacts of a face that is no reading of a rim
_BEFORE = 3.0  # [mm] in front of a face, from which a contact cannot be of one convex body with it
_WIDE = 3.0  # [mm] standard deviation of a sound face's contacts across their longer extent
_BULGE = 0.02  # [mm] rms about a plane, up to which a face is flat
_SAGITTA = 0.05  # [mm] of bulge, which a pad that lies partly past a small face's rim may read into it
_NO_WORSE = 1.3  # times the misfit of a curved face, up to which a plane explains as much
_AS_NEAR = 1.1  # times its distance of places, up to which only normals ask for the curve,
_LEAN = 1.5  # [sigma] that most of those lean at least, where it is not a few strays
_FLAT = 5.0  # times the extent of what was touched, from which a radius is that of a plane
_ARC = 0.05  # [rad] of a land that was felt along its length, up to which it is flat across
_FACING = 0.98  # least cosine between a contact's normal and that of the larger face
_LEANS = 0.996  # the same, of a pad that leans over its rim: contacts are before it, and of a bevel none is
_AT_RIM = 0.5  # [mm] from a larger face, within which a contact of a pad that lies on its rim is
_BOWED = 1.0  # [mm] from a ring, within which a band that bends with its crest was read flat
_EDGE_SHARE = 0.8  # of a face's contacts, that make it an edge


def drop_false(graph: PatchGraph) -> PatchGraph:
    """The graph less what a pad read on an object of any form, where none of its faces is."""
    return drop_poor(drop_rims(drop_edges(graph)), _HOPELESS)


def drop_edges(graph: PatchGraph) -> PatchGraph:
    """The graph less its faces that are the edge of two others, or lie on a larger one; the poorest first."""
    for face in sorted(graph.faces, key=lambda f: len(f.contacts)):
        others = [f for f in graph.faces if f.id != face.id and isinstance(f.fit, Fit)]
        if len(others) < 2 or not len(face.contacts):
            continue
        away = np.array([np.abs(_shape(f).signed_distance(face.contacts.points)) for f in others])
        on_edge = np.sort(away, axis=0)[1] < _ON_EDGE
        larger = np.array([len(f.contacts) > _LARGER * len(face.contacts) for f in others])
        facing = np.array([(_outward(f, face.contacts) * face.contacts.normals).sum(axis=1) for f in others])
        near = _ON_EDGE if len(face.contacts) < _FEW else _SAME
        on_larger = ((away[larger] < near) & (facing[larger] > _FACING)).any(axis=0)
        if float(on_edge.mean()) > _EDGE_SHARE or float(on_larger.mean()) > _EDGE_SHARE:
            graph = _without(graph, face.id)
    return graph


def drop_rims(graph: PatchGraph) -> PatchGraph:
    """The graph less its faces that were read where a pad lay on a rim, or across a step from rim to rim.

    All contacts of such a face lie on larger ones, and most look another way than those do: so does what a pad
    reads off the crest of a narrow ring, which it takes for flat.
    """
    for face in sorted(graph.faces, key=lambda f: len(f.contacts)):
        felt = face.contacts.select(face.contacts.touch != NOT_FELT)
        larger = [
            f for f in graph.faces if isinstance(f.fit, Fit) and f is not face and _reaches_past(f, face)
        ]
        if not len(felt) or not larger:
            continue
        facing = np.array([(_outward(f, felt) * felt.normals).sum(axis=1) for f in larger])
        ring = np.array([[isinstance(f.fit, Fit) and f.fit.kind == "torus"] for f in larger])
        before = np.array([_before(f, felt.points) for f in larger])
        over = (before.max(axis=1, keepdims=True) > _SAME) & (facing < _LEANS)
        near = np.where(ring, _BOWED, np.where((facing < _FACING) | over, _AT_RIM, _SAME))
        if float((np.abs(before) < near).any(axis=0).mean()) > _EDGE_SHARE:
            graph = _without(graph, face.id)
    return graph


def _reaches_past(larger: Face, face: Face) -> bool:
    """Whether a face is so well known that another may be a reading of it; rings are read as others all round."""
    assert isinstance(larger.fit, Fit)
    ring = larger.fit.kind == "torus" and len(larger.contacts) >= 2 * _SOUND
    return ring or len(larger.contacts) > _LARGER * len(face.contacts)


def concave(graph: PatchGraph) -> bool:
    """Whether sound faces cannot all bound a convex body: many contacts of one lie well before another.

    A torus turns away from its own far side, so that no half-space stands for it.
    """
    sound = [f for f in graph.faces if isinstance(f.fit, Fit) and len(f.contacts) >= _SOUND and _broad(f)]
    for face in sound:
        assert isinstance(face.fit, Fit)
        side = 1.0 if face.fit.convex else -1.0
        if (not face.fit.convex and face.fit.kind != "plane") or face.fit.kind == "torus":
            return True
        for other in sound:
            away = side * face.fit.shape.signed_distance(other.contacts.points)
            if other is not face and int((away > _BEFORE).sum()) >= _SOUND // 2:
                return True
    return False


def _broad(face: Face) -> bool:
    """Whether a face was touched over more than the rim that may look like one."""
    spread = np.linalg.svd(face.contacts.points - face.contacts.points.mean(axis=0), compute_uv=False)
    return bool(spread[1] / np.sqrt(len(face.contacts)) > _WIDE)


def drop_poor(graph: PatchGraph, most: float = _POOR) -> PatchGraph:
    """The graph less its faces of few contacts that scatter, as of a pad that lay across an inside corner.

    They scatter by more than `most` [mm] rms over what they say that they err; those that are hopelessly unsure of
    themselves tell nothing of that.  A sound face may have strays, but most of its contacts lie on it.  In a
    trough, which a pad bridges, they may lie further off.
    """
    for face in graph.faces:
        if isinstance(face.fit, Fit) and len(face.contacts) < _FEW:
            off = np.abs(face.fit.shape.signed_distance(face.contacts.points))
            tells = face.contacts.sigma <= _HOPELESS
            sigma = face.weighed.sigma[tells]
            few = len(sigma) < min(_TELLING, len(off))
            over = np.average(off[tells] ** 2 - sigma**2, weights=sigma**-2) if len(sigma) else 0.0
            scatter = float(np.sqrt(max(0.0, over)))
            bound = _HOPELESS if len(off) >= _SOUND and _bends(face) else most
            if few or (scatter > bound and (len(off) < _SOUND or float(np.quantile(off, _AGREE)) > bound)):
                graph = _without(graph, face.id)
    return graph


def _bends(face: Face) -> bool:
    """Whether a face was felt so far round that what a pad bridges there moves it, and does not make it up."""
    fit = face.fit
    if not isinstance(fit, Fit) or fit.kind == "plane" or not _broad(face):
        return False
    normals = face.contacts.normals[np.isfinite(face.contacts.normals).all(axis=1)]
    return len(normals) > 0 and float((normals @ normals.T).min()) < _ROUND


def drop_astride(graph: PatchGraph) -> PatchGraph:
    """The graph less round faces of few contacts that reach past both sides of a sheet: a pad across its edge."""
    flat = [face for face in graph.faces if isinstance(face.fit, Fit) and face.fit.kind == "plane"]
    for face in graph.faces:
        few = isinstance(face.fit, Fit) and face.fit.kind != "plane" and len(face.contacts) < _SOUND
        if few and any(_astride(face, one, other) for one, other in combinations(flat, 2)):
            graph = _without(graph, face.id)
    return graph


def _astride(face: Face, one: Face, other: Face) -> bool:
    """Whether contacts of a face lie past each of two that are the sides of a sheet, and were felt near them."""
    points = face.contacts.points
    up = _outward(one, one.contacts)[0]
    deep = float((one.contacts.points.mean(axis=0) - other.contacts.points.mean(axis=0)) @ up)
    if not 0.0 < deep < _SHEET or float(_outward(other, other.contacts)[0] @ up) > -_FACING:
        return False
    past = [
        side.fit.shape.signed_distance(points).max() for side in (one, other) if isinstance(side.fit, Fit)
    ]
    near = [np.linalg.norm(side.contacts.points - points.mean(axis=0), axis=1).min() for side in (one, other)]
    return bool(min(past) > _ASTRIDE and max(near) < _NEAR)


def flattened(graph: PatchGraph) -> PatchGraph:
    """The graph with planes for faces that curve so little that what was touched of them is flat.

    Over an extent e a curve of radius r bulges by e^2 / (8 r).  Narrow faces, felt by pads that reach past them,
    may read so.
    """
    faces = []
    for face in graph.faces:
        flat = _plane_of(face)
        faces.append(face if flat is None else replace(face, fit=flat, ranked=()))
    return replace(graph, faces=tuple(faces))


def _plane_of(face: Face) -> Fit | None:
    """The plane that says of a hardly curved face what there is to say."""
    bulge = _bulge(face)
    flat = None if bulge is None else fit("plane", face.weighed)
    if bulge is None or not isinstance(flat, Fit) or not isinstance(face.fit, Fit):
        return None
    as_near = flat.rms < _AS_NEAR * face.fit.rms and _median_lean(flat, face.contacts) < _LEAN
    told = as_near or flat.rms < _BULGE or bulge < _SAGITTA or flat.chi2 < _NO_WORSE * face.fit.chi2
    return flat if told else None


def _median_lean(flat: Fit, contacts: Contacts) -> float:
    """[sigma] by which normals lean from a plane's."""
    facing = np.abs((flat.shape.normals(contacts.points) * contacts.normals).sum(axis=1))
    return float(np.median(np.arccos(np.clip(facing, 0.0, 1.0)) / contacts.normal_sigma))


def _bulge(face: Face) -> float | None:
    """[mm] by which a hardly curved face bulges over what was touched of it; None where it is not."""
    if not isinstance(face.fit, Fit):
        return None
    radius = getattr(face.fit.shape, "radius", None)
    if radius is None or len(face.contacts) < _SOUND:
        return None
    extent = float(np.ptp(face.contacts.points, axis=0).max())
    least = _FLAT * extent
    if isinstance(face.fit.shape, Cylinder):  # along its axis it is straight
        extent = float(np.ptp(face.contacts.points @ face.fit.shape.frame[:, :2], axis=0).max())
        least = min(least, extent / _ARC)
    return extent**2 / (8.0 * radius) if radius > least else None


def drop_contradicted(graph: PatchGraph) -> PatchGraph:
    """The graph less its faces that too many contacts contradict, the worst first."""
    while True:
        worst = _worst(graph)
        if worst is None:
            return graph
        graph = _without(graph, worst)


def _without(graph: PatchGraph, face_id: int) -> PatchGraph:
    faces = tuple(face for face in graph.faces if face.id != face_id)
    edges = tuple(edge for edge in graph.edges if face_id not in edge.faces)
    return replace(graph, faces=faces, edges=edges)


def _outward(face: Face, contacts: Contacts) -> Floats:
    """(n, 3) outward normals of a face where contacts are nearest to it."""
    assert isinstance(face.fit, Fit)
    return np.asarray(face.fit.shape.normals(contacts.points) * (1.0 if face.fit.convex else -1.0))


def _before(face: Face, points: Floats) -> Floats:
    """(n,) [mm] that points are before a face."""
    assert isinstance(face.fit, Fit)
    return face.fit.shape.signed_distance(points) * (1.0 if face.fit.convex else -1.0)


def _shape(face: Face) -> Shape:
    assert isinstance(face.fit, Fit)
    return face.fit.shape


def _worst(graph: PatchGraph) -> int | None:
    against: dict[int, float] = {}
    for face in graph.faces:
        if not isinstance(face.fit, Fit):
            continue
        others = [f.contacts for f in graph.faces if f.id != face.id]
        if not others:
            continue
        contacts = Contacts.concatenate(others)
        before = _before(face, contacts.points)
        facing = np.nan_to_num((_outward(face, contacts) * contacts.normals).sum(axis=1), nan=1.0)
        along = np.sqrt(np.maximum(0.0, 1.0 - facing**2))
        beyond = int((before > _BEYOND + _PAST * along).sum())
        if beyond > _MOST and beyond > _SHARE * len(face.contacts):
            against[face.id] = beyond / len(face.contacts)
    return max(against, key=lambda face_id: against[face_id], default=None)
