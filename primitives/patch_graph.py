"""The boundary while it grows: fitted faces, traced edges, and which edge still lacks a face.

A graph never changes; each method returns a new one.  Identities last: a face keeps its id while it grows, and
of two that merge the lower id stays.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np
from scipy.special import chdtri

from primitives.arrays import Bools, frozen
from primitives.classify import RankedFit, RankOptions, rank, score, two_flats
from primitives.errors import PalpateError
from primitives.evidence import NOT_FELT, Contacts, EdgeTrace
from primitives.fit import Fit, NoFit, fit, refit


@dataclass(frozen=True)
class MergeOptions:
    """When two lots of contacts lie on one face."""

    slack: float = 1.5  # factor on every sigma, for what the sensor model leaves out
    scatter: float = 0.0  # [mm] that contacts err by beside their own sigmas, as the stage makes them
    significance: float = 1e-4  # a joint fit less likely than this is refused
    strained: float = 1.5  # chi2 per degree of freedom from which contacts that stray are looked for
    agreeing: float = 0.7  # share of the contacts that must agree on a shape for the rest to have strayed
    certain: float = 0.999  # probability at which a face's kind is settled, so that no other is tried for it
    rank: RankOptions = field(default_factory=RankOptions)


@dataclass(frozen=True)
class Face:
    """A smooth face as far as it is known."""

    id: int
    fit: Fit | NoFit
    contacts: Contacts
    ranked: tuple[RankedFit, ...] = ()
    scatter: float = 0.0  # [mm] that its contacts were taken to err by beside their own sigmas

    @property
    def weighed(self) -> Contacts:
        """The contacts with the sigmas that they were fitted with."""
        return _weighed(self.contacts, self.scatter)

    def only(self, kept: Bools) -> Face:
        """The face with those of its contacts alone, its fit as it was; itself where that is all or none."""
        if kept.all() or not kept.any() or not isinstance(self.fit, Fit):
            return self
        fit = replace(self.fit, inliers=frozen(self.fit.inliers[kept], bool))
        return replace(self, fit=fit, contacts=self.contacts.select(kept))


@dataclass(frozen=True)
class Edge:
    """An edge, and the one or two faces that are known to meet there."""

    id: int
    trace: EdgeTrace | None
    faces: tuple[int, int | None]


@dataclass(frozen=True)
class PatchGraph:
    """Faces and edges found so far."""

    faces: tuple[Face, ...] = ()
    edges: tuple[Edge, ...] = ()
    options: MergeOptions = field(default_factory=MergeOptions)
    apart: tuple[tuple[Face, Face], ...] = field(
        default=(), repr=False, compare=False
    )  # which are known to be two

    def scattered(self, scatter: float) -> PatchGraph:
        """The graph of contacts that err by so much [mm] beside their own sigmas, its shapes fitted anew."""
        options = replace(self.options, scatter=scatter)
        faces = tuple(_refitted(face, options) for face in self.faces)
        return replace(self, faces=faces, options=options, apart=())

    def believed(self, contacts: Contacts) -> Contacts:
        """Contacts of it, with what the stage adds to the sigmas of those that were felt."""
        return _weighed(contacts, self.options.scatter)

    @property
    def next_id(self) -> int:
        """The id of a face that is added."""
        return 1 + max((face.id for face in self.faces), default=-1)

    def face(self, face_id: int) -> Face:
        """The face of an id."""
        for face in self.faces:
            if face.id == face_id:
                return face
        raise PalpateError(f"no face {face_id}; there are {[face.id for face in self.faces]}")

    def edges_of(self, face_id: int) -> tuple[Edge, ...]:
        """The edges known to bound a face."""
        return tuple(edge for edge in self.edges if face_id in edge.faces)

    def open_edges(self) -> tuple[Edge, ...]:
        """The edges that know only one face."""
        return tuple(edge for edge in self.edges if edge.faces[1] is None)

    def add_stroke(self, contacts: Contacts) -> tuple[PatchGraph, int]:
        """The graph with a stroke's contacts, and the face that they joined or opened."""
        stroke = ranked_face(self.next_id, contacts, self.options)
        joined = [(found, face) for face in self.faces if (found := join(face, stroke, self.options))]
        if not joined:
            return replace(self, faces=(*self.faces, stroke)), stroke.id
        home = min(joined, key=lambda pair: pair[0].chi2 / max(pair[0].dof, 1))[1]
        return self.add_contacts(contacts, home.id), home.id

    def add_contacts(self, contacts: Contacts, face_id: int) -> PatchGraph:
        """The graph with contacts known to lie on a face, which is fitted and ranked anew."""
        merged = Contacts.concatenate([self.face(face_id).contacts, contacts])
        return self._with_face(ranked_face(face_id, merged, self.options))

    def add_trace(self, trace: EdgeTrace | None, face_id: int) -> tuple[PatchGraph, int]:
        """The graph with an edge of a face, its other face unknown, and the edge's id."""
        self.face(face_id)
        edge = Edge(1 + max((edge.id for edge in self.edges), default=-1), trace, (face_id, None))
        return replace(self, edges=(*self.edges, edge)), edge.id

    def attach(self, edge_id: int, face_id: int) -> PatchGraph:
        """The graph in which an edge knows its other face."""
        self.face(face_id)
        if all(edge.id != edge_id for edge in self.edges):
            raise PalpateError(f"no edge {edge_id}; there are {[edge.id for edge in self.edges]}")
        edges = tuple(
            replace(edge, faces=(edge.faces[0], face_id)) if edge.id == edge_id else edge
            for edge in self.edges
        )
        return replace(self, edges=edges)

    def merge_faces(self) -> tuple[PatchGraph, dict[int, int]]:
        """The graph in which no two faces are one, and where each id that vanished went.

        An edge whose two faces turn out to be one was none, and goes.
        """
        graph, gone = self, dict[int, int]()
        while True:
            graph, pair = graph._joinable()
            if pair is None:
                return graph, gone
            kept, lost = pair
            gone = {old: kept.id if new == lost else new for old, new in gone.items()} | {lost: kept.id}
            faces = tuple(kept if face.id == kept.id else face for face in graph.faces if face.id != lost)
            edges = tuple(_renamed(edge, lost, kept.id) for edge in graph.edges)
            graph = replace(graph, faces=faces, edges=tuple(e for e in edges if e.faces[0] != e.faces[1]))

    def _joinable(self) -> tuple[PatchGraph, tuple[Face, int] | None]:
        """The first two faces that are one, as one, and the second's id; the graph knows which are two.

        Of two faces that have not changed since they were found to be two, that is not asked again.
        """
        known, apart = {(id(a), id(b)) for a, b in self.apart}, list[tuple[Face, Face]]()
        for first, second in combinations(self.faces, 2):
            if (id(first), id(second)) not in known and join(first, second, self.options):
                contacts = Contacts.concatenate([first.contacts, second.contacts])
                one = ranked_face(first.id, contacts, self.options)
                return replace(self, apart=(*self.apart, *apart)), (one, second.id)
            apart.append((first, second))
        return replace(self, apart=tuple(apart)), None

    def _with_face(self, face: Face) -> PatchGraph:
        return replace(self, faces=tuple(face if f.id == face.id else f for f in self.faces))


def join(first: Face, second: Face, options: MergeOptions) -> Fit | None:
    """The fit of both faces' contacts by one shape; None where two shapes explain them better.

    The shapes at hand are refitted first, which is quick; only where that fails is every kind tried.
    """
    contacts = _weighed(Contacts.concatenate([first.contacts, second.contacts]), options.scatter)
    for face in (first, second):
        if isinstance(face.fit, Fit):
            near = refit(face.fit.shape, face.fit.convex, contacts, options.rank.fit)
            if not isinstance(near, Fit) or two_flats(near, contacts, options.rank):
                continue
            if _pays(near, first, second, options):
                return near
    if _settled(first, second, options):
        return None
    ranked = rank(contacts, options=options.rank)
    if ranked and _pays(ranked[0].fit, first, second, options):
        return ranked[0].fit
    return None


def ranked_face(face_id: int, contacts: Contacts, options: MergeOptions) -> Face:
    """A face fitted with the likeliest shape, to the contacts that agree on one.

    Contacts that stray, as of a pad that lay half over an edge, stay with the face and out of its fit.
    """
    weighed = _weighed(contacts, options.scatter)
    ranked = rank(weighed, options=options.rank)
    if ranked and ranked[0].fit.chi2 > options.strained * max(ranked[0].fit.dof, 1):
        kept = _agreeing(ranked[0].fit.kind, weighed, options)
        if kept is not None:
            again = rank(weighed.select(kept), options=options.rank)
            ranked = tuple(replace(r, fit=replace(r.fit, inliers=frozen(kept, bool))) for r in again)
    found = ranked[0].fit if ranked else NoFit(f"{len(contacts)} contacts determine no shape")
    return Face(face_id, found, contacts, ranked, options.scatter)


def _weighed(contacts: Contacts, scatter: float) -> Contacts:
    """Contacts with what the stage adds to the sigmas of those that were felt."""
    if not scatter:
        return contacts
    added = np.where(contacts.touch == NOT_FELT, 0.0, scatter)
    return replace(contacts, sigma=frozen(np.hypot(contacts.sigma, added)))


def _refitted(face: Face, options: MergeOptions) -> Face:
    """A face that was felt, fitted with other sigmas; one that was never ranked keeps its shape and its strays."""
    if not isinstance(face.fit, Fit) or (face.contacts.touch == NOT_FELT).any():
        return face
    if face.ranked:
        again = ranked_face(face.id, face.contacts, options)
        return again if isinstance(again.fit, Fit) else face
    kept = face.fit.inliers
    contacts = _weighed(face.contacts.select(kept), options.scatter)
    found = refit(face.fit.shape, face.fit.convex, contacts, options.rank.fit)
    if not isinstance(found, Fit):
        return face
    return replace(face, fit=replace(found, inliers=kept), scatter=options.scatter)


def _agreeing(kind: str, contacts: Contacts, options: MergeOptions) -> Bools | None:
    """(n,) the contacts that a robust fit explains, where some stray and most do not."""
    found = fit(kind, contacts, replace(options.rank.fit, robust=True))
    if not isinstance(found, Fit):
        return None
    share = float(found.inliers.mean())
    return found.inliers if options.agreeing <= share < 1.0 else None


def explains(found: Fit, options: MergeOptions) -> bool:
    """Whether chi2 is as small as noise, with the slack, allows."""
    bound = chdtri(max(found.dof, 1), options.significance)
    return bool(found.chi2 <= options.slack**2 * bound)


def _pays(joint: Fit, first: Face, second: Face, options: MergeOptions) -> bool:
    if not explains(joint, options):
        return False
    apart = sum(_least_score(face, options) for face in (first, second))
    return score(joint, options.rank, options.slack**2) <= apart


def _settled(first: Face, second: Face, options: MergeOptions) -> bool:
    larger = first if len(first.contacts) >= len(second.contacts) else second
    return bool(larger.ranked) and larger.ranked[0].probability > options.certain


def _least_score(face: Face, options: MergeOptions) -> float:
    if isinstance(face.fit, Fit):
        alike = face if face.scatter == options.scatter else _refitted(face, options)
        assert isinstance(alike.fit, Fit)
        return score(alike.fit, options.rank, options.slack**2)
    return 3.0 * float(np.log(max(len(face.contacts), 2)))  # too few to fit: a plane could hold them all


def _renamed(edge: Edge, old: int, new: int) -> Edge:
    first, second = edge.faces
    return replace(edge, faces=(new if first == old else first, new if second == old else second))
