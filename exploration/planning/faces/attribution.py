"""Which face each contact belongs to, and when contacts that belong to none make a new one.

A contact belongs to the face that it lies on and faces like.  What no face explains is kept: a small face yields a
few contacts a visit, and those of several visits together make it known.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from exploration.planning.faces.coaxial import coaxial_face
from exploration.planning.faces.consistency import concave, drop_contradicted, drop_edges, drop_false
from exploration.planning.faces.hollows import hollow_face
from exploration.planning.faces.repeated import repeated_face
from exploration.planning.faces.two_sides import two_sides
from primitives.arrays import Floats, Ints
from primitives.classify import RankOptions
from primitives.evidence import Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face, MergeOptions, PatchGraph, ranked_face
from primitives.segment import segment
from primitives.shared_error import with_shared_error
from primitives.surface_sigma import distance_sigma

CONVEX = MergeOptions(
    slack=3.0,  # errors common to a stroke are larger than its frames' noise
    rank=RankOptions(
        prior={"plane": 0.5, "cylinder": 0.25, "cone": 0.1, "sphere": 0.1, "torus": 0.05},
        largest_torus=3.0,
        least_turn=0.5,
        least_arc=0.3,
        of_a_line=(4, 4),  # of a cylinder a pad feels more than a line, of a plate's side it does not
    ),
)


@dataclass(frozen=True)
class AttributionConfig:
    """When a contact belongs to a face, and contacts make one."""

    near: float = 0.1  # [mm] a contact this far from a known face belongs to it
    turned: float = 0.06  # [rad] as long as its normal is no farther off
    unsure: float = 1.0  # [mm] at most, that a face may be off where it is not known well
    misfit: float = 8.0  # chi2 per degree of freedom of a face that is none
    least_contacts: int = 5  # that make a new face, or
    least_clean: int = 4  # of one frame that shows nothing but surface,
    clean: float = 0.0125  # [mm] if none of them errs by more
    poor: float = 0.05  # [mm] of a contact's deviation, from which a face takes two touches,
    most: float = 0.4  # quantile of them that says so of all
    least_share: float = 0.3  # of a visit's contacts that must be unexplained to make one at once
    flat_share: float = 0.6  # of them, that lie on one plane where the others are strays,
    flat_off: float = 0.15  # [mm] from it at most,
    flat_facing: float = 0.998  # and least cosine of their normals with its own
    pool: float = 20.0  # [mm] within which the unexplained contacts of several visits are put together
    facing: float = 0.95  # least cosine of their normals with the first one's
    wide: float = 30.0  # [mm] within which contacts are put together that may face any way
    curled: float = 0.05  # [mm] most rms of those
    curled_touches: int = 3  # of a face so narrow that no two touches of it face alike
    spare: int = 2  # contacts more than parameters, of a cone or a ring
    convex: bool = True  # whether the object may be taken for convex, so that faces may contradict each other


@dataclass(frozen=True)
class Taken:
    """What became of one visit's contacts."""

    graph: PatchGraph
    loose: Contacts  # what no face explains, from this visit and earlier ones
    home: int | None  # the face that the visit was on
    gone: dict[int, int]  # faces that turned out to be another
    hollow: bool  # whether the faces bound no convex body


def known_face(graph: PatchGraph, contacts: Contacts, config: AttributionConfig) -> int | None:
    """The face that these contacts lie on, if it is one of those found."""
    for face in graph.faces:
        if (
            isinstance(face.fit, Fit)
            and len(contacts)
            and np.median(_misfit(graph, face, contacts, config)) < 1.0
        ):
            return face.id
    return None


def joined(graph: PatchGraph, contacts: Contacts, face: int, config: AttributionConfig) -> PatchGraph:
    """The graph with contacts given to a face, unless no one shape explains it any more."""
    if not len(contacts):
        return graph
    return _sound(graph.add_contacts(contacts, face), face, config) or graph


def take_in(graph: PatchGraph, loose: Contacts, contacts: Contacts, config: AttributionConfig) -> Taken:
    """Give contacts to the faces that explain them; what is left over is a new face, if there is enough."""
    owner = _owners(graph, contacts, config)
    for face_id in np.unique(owner[owner >= 0]):
        graph = joined(graph, contacts.select(owner == face_id), int(face_id), config)
    home = int(np.bincount(owner[owner >= 0]).argmax()) if (owner >= 0).any() else None
    rest, gone = contacts.select(owner < 0), dict[int, int]()
    loose = Contacts.concatenate([loose, rest])
    enough = len(rest) >= config.least_share * len(contacts)
    alone = (rest, _beside(rest, rest, config), _flat_part(rest, config)) if enough else ()
    about = _about(loose, rest, config)
    for lot in (*alone, _beside(loose, rest, config), about):
        if not _enough(lot, config) or _hearsay(lot, config):
            continue
        grown, opened = graph.add_stroke(lot)
        accepted = _sound(grown, opened, config)
        if accepted is not None and not _told(accepted.face(opened), lot is about, config):
            accepted = None
        if accepted is not None:
            graph, gone = accepted.merge_faces()
            home = gone.get(opened, opened)
            loose = without(loose, lot)
            break
    hollow = not config.convex or concave(graph)
    graph, loose = _cleared(graph, loose, hollow, config)
    return Taken(graph, loose, home if any(f.id == home for f in graph.faces) else None, gone, hollow)


def name_loose(graph: PatchGraph, loose: Contacts, config: AttributionConfig) -> Taken:
    """Make faces of what none explains, seen as a cloud: a ring is felt in places that lie and face all apart.

    What then lies round an axis that is known is a cylinder; so is what lies where one of equal faces would come
    again, and what one touch felt all round it in a hollow.
    """
    cloud = loose
    for found in segment(cloud):
        lot = cloud.select(found.rows)
        number = graph.next_id
        face = ranked_face(number, lot, graph.options)
        close = isinstance(face.fit, Fit) and face.fit.rms < config.curled
        if close and len(np.unique(lot.touch)) >= config.curled_touches and _told(face, False, config):
            graph, loose = replace(graph, faces=(*graph.faces, face)), without(loose, lot)
    while (more := _one_more(graph, loose)) is not None:
        graph, loose = replace(graph, faces=(*graph.faces, more)), without(loose, more.contacts)
    graph, gone = graph.merge_faces()
    return Taken(*_cleared(graph, loose, True, config), None, gone, True)


def _one_more(graph: PatchGraph, loose: Contacts) -> Face | None:
    """A face of contacts too few to name one by themselves, that what is known already names."""
    return coaxial_face(graph, loose) or repeated_face(graph, loose) or hollow_face(graph, loose)


def _cleared(
    graph: PatchGraph, loose: Contacts, hollow: bool, config: AttributionConfig
) -> tuple[PatchGraph, Contacts]:
    """The graph without faces that were none, and what is loose then."""
    kept = drop_false(graph) if hollow else drop_edges(drop_contradicted(graph))
    staying = {face.id for face in kept.faces}
    dropped = [face.contacts for face in graph.faces if face.id not in staying]
    return _settled(kept, Contacts.concatenate([loose, *dropped]), config)


def without(contacts: Contacts, taken: Contacts) -> Contacts:
    """The contacts less those of another table."""
    gone = set(map(bytes, taken.points))
    return contacts.select(np.array([bytes(p) not in gone for p in contacts.points], dtype=bool))


def _misfit(graph: PatchGraph, face: Face, contacts: Contacts, config: AttributionConfig) -> Floats:
    """(n,) distance and turn from a fitted face, in units of what still belongs to it.

    A curved face that was felt at one end may lie farther off at the other than any contact errs.
    """
    fit, unsure = face.fit, np.zeros(len(contacts))
    assert isinstance(fit, Fit)
    if fit.kind != "plane" and len(contacts):
        sigma = distance_sigma(with_shared_error(fit, face.weighed), contacts.points)
        unsure = np.minimum(3.0 * sigma, config.unsure)
    errs = np.hypot(contacts.sigma, graph.options.scatter)
    room = np.hypot(np.hypot(4.0 * errs, config.near), unsure)
    off = np.abs(fit.shape.signed_distance(contacts.points)) / room
    side = 1.0 if fit.convex else -1.0
    facing = side * (fit.shape.normals(contacts.points) * contacts.normals).sum(axis=1)
    turn = np.arccos(np.clip(facing, -1.0, 1.0)) / np.hypot(3.0 * contacts.normal_sigma, config.turned)
    return np.asarray(np.maximum(off, turn))


def _owners(graph: PatchGraph, contacts: Contacts, config: AttributionConfig) -> Ints:
    owner = np.full(len(contacts), -1)
    best = np.ones(len(contacts))
    for face in graph.faces:
        if isinstance(face.fit, Fit) and len(contacts):
            off = _misfit(graph, face, contacts, config)
            closer = off < best
            owner[closer], best[closer] = face.id, off[closer]
    return owner


def _enough(lot: Contacts, config: AttributionConfig) -> bool:
    """Whether contacts may make a face: on a narrow land a pad that lies flush is all that there is."""
    clean = not config.convex and len(lot) >= config.least_clean and float(lot.sigma.max()) < config.clean
    return clean or len(lot) >= config.least_contacts


def _hearsay(lot: Contacts, config: AttributionConfig) -> bool:
    """Whether contacts are poor and of one touch: a pad that slid over a rim reads such where no face is."""
    return float(np.quantile(lot.sigma, config.most)) > config.poor and len(np.unique(lot.touch)) < 2


def _settled(graph: PatchGraph, loose: Contacts, config: AttributionConfig) -> tuple[PatchGraph, Contacts]:
    """The graph with what was loose given to the faces that now explain it, and what still is."""
    owner = _owners(graph, loose, config)
    for face_id in np.unique(owner[owner >= 0]):
        graph = joined(graph, loose.select(owner == face_id), int(face_id), config)
    return graph, loose.select(owner < 0)


def _beside(contacts: Contacts, rest: Contacts, config: AttributionConfig) -> Contacts:
    """Those contacts that lie beside the first of `rest`, where the pad came down, and face as it does."""
    if not len(rest):
        return rest
    near = np.linalg.norm(contacts.points - rest.points[0], axis=1) < config.pool
    return contacts.select(near & (contacts.normals @ rest.normals[0] > config.facing))


def _flat_part(rest: Contacts, config: AttributionConfig) -> Contacts:
    """Those contacts that lie on one plane, where they are most: a pad that came down askew reads a few others."""
    if len(rest) < config.least_contacts:
        return rest.select(np.zeros(len(rest), dtype=bool))
    normal = np.median(rest.normals, axis=0)
    normal = normal / max(float(np.linalg.norm(normal)), 1e-9)
    off = rest.points @ normal
    flat = (rest.normals @ normal > config.flat_facing) & (np.abs(off - np.median(off)) < config.flat_off)
    return rest.select(flat & (flat.mean() >= config.flat_share))


def _about(contacts: Contacts, rest: Contacts, config: AttributionConfig) -> Contacts:
    """Those contacts that lie beside the first of `rest`, whatever way they face, as in a countersink."""
    if config.convex or not len(rest):
        return rest.select(np.zeros(len(rest), dtype=bool))
    near = contacts.select(np.linalg.norm(contacts.points - rest.points[0], axis=1) < config.wide)
    few = len(np.unique(near.touch)) < config.curled_touches
    return near.select(np.zeros(len(near), dtype=bool)) if few else near


def _told(face: Face, any_way: bool, config: AttributionConfig) -> bool:
    """Whether contacts tell enough of a face; those that face `any_way` are to lie on a round one, and closely."""
    fit = face.fit
    if config.convex:
        return True
    if two_sides(face):
        return False
    if not isinstance(fit, Fit):
        return True
    if any_way and (fit.kind == "plane" or fit.rms > config.curled):
        return False
    return fit.kind not in ("cone", "torus") or len(face.contacts) >= fit.shape.dof + config.spare


def _sound(graph: PatchGraph, face_id: int, config: AttributionConfig) -> PatchGraph | None:
    """The graph, unless no one shape explains a face of it."""
    fit = graph.face(face_id).fit
    broken = isinstance(fit, Fit) and fit.chi2 > config.misfit * max(fit.dof, 1)
    return None if broken else graph
