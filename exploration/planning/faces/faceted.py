"""Round faces of which an array felt the facets: narrow flats that are tangents of one of them, taken together.

Who turns a cylinder, cone or ball into a coarse mesh gives it many narrow sides, and a pad that is wider than one
of them lies flat on it.  Planes with normals n_i and offsets d_i are tangents of one ball about c where

    d_i = c . n_i + rho,

and rho is negative where they look at c.  They are those of a cone or cylinder about an axis a through c where

    n_i . a = s

as well, with s = 0 for the cylinder; all of it is linear.  Five flats of a ring and more, or eight of a ball, each
turned a little from the next, are such a face: who means so many sides means what is round.  So are two round
faces that lie in each other, which their facets alone tell apart (our derivation).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, permutations

import numpy as np
from scipy.spatial import KDTree

from primitives.arrays import Bools, Floats, frozen
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit, fit
from primitives.patch_graph import Face, PatchGraph
from primitives.pose import frame_along
from primitives.shapes import Sphere

_ROUND = "cylinder", "cone", "sphere"
_ALONE = 1_000_000  # more touches than any exploration makes


@dataclass(frozen=True)
class FacetedConfig:
    """When flats are facets of a round face, and what else is of it."""

    turns: tuple[float, float] = (0.05, 0.45)  # [rad] from a facet to the next: of 14 sides and more
    least: int = 5  # facets of one ring,
    least_ball: int = 8  # and of a ball
    tried: int = 8  # flats round one, of which a few with it tell a face
    contacts: int = 6  # of a flat, that tell how it stands
    same: float = 0.012  # of the cosine with the axis, between facets of one ring,
    near: float = 1.0  # [mm] from tangents of what a few of them tell,
    off: float = 0.2  # and from those of what all do
    radii: tuple[float, float] = (4.0, 250.0)  # [mm] of the face
    upright: float = 0.02  # cosine of its facets with its axis, up to which it is a cylinder
    steepest: float = 0.96  # the same, from which flats are no facets of a cone
    on: float = (
        0.25  # [mm] past the facets' corners or middles, up to which what else was felt is of the face,
    )
    aside: float = 0.1  # [rad] more than half a turn to the next, that it looks aside,
    mostly: float = 0.9  # and the share of its contacts, that do so
    many: int = 30  # contacts of a round face that a pad could span facets of,
    leaning: float = 3.0  # [sigma] that its normals lean for the most part, if it did
    among: float = 6.0  # [mm] from a contact of such a face to one of another that lies in it,
    mixed: float = 0.5  # for such a share of them
    twin: float = 0.15  # [mm] rms of contacts from one face


@dataclass(frozen=True)
class _Flats:
    """Flat faces by what they are tangents of."""

    faces: tuple[Face, ...]
    normals: Floats  # (n, 3) outward
    offsets: Floats  # (n,) [mm] along them


@dataclass(frozen=True)
class _Round:
    """What flats are tangents of."""

    center: Floats  # (3,) [mm] on its axis, or of the ball
    rho: float  # [mm] of a tangent from there
    axis: Floats | None = None  # (3,) unit; None of a ball
    along: float = 0.0  # cosine of a facet's normal with the axis

    @staticmethod
    def ring(normals: Floats, offsets: Floats) -> _Round:
        """Nearest to (n, 3) normals and their offsets, three and more."""
        axis = np.linalg.svd(normals - normals.mean(axis=0))[2][2]
        across = frame_along(axis)[:, :2]
        rows = np.column_stack([normals @ across, np.ones(len(normals))])
        solved = np.linalg.lstsq(rows, offsets)[0]
        return _Round(across @ solved[:2], float(solved[2]), axis, float((normals @ axis).mean()))

    @staticmethod
    def ball(normals: Floats, offsets: Floats) -> _Round:
        """Nearest to (n, 3) normals and their offsets, four and more."""
        solved = np.linalg.lstsq(np.column_stack([normals, np.ones(len(normals))]), offsets)[0]
        return _Round(np.asarray(solved[:3]), float(solved[3]))

    def holds(self, flats: _Flats, off: float, same: float) -> Bools:
        """(n,) which flats are tangents of it."""
        near = np.abs(flats.offsets - flats.normals @ self.center - self.rho) < off
        return near if self.axis is None else near & (np.abs(flats.normals @ self.axis - self.along) < same)

    def kind(self, config: FacetedConfig) -> str | None:
        """Of the face; None where it is too flat or too small for one."""
        slope = float(np.sqrt(max(1.0 - self.along**2, 1e-9)))
        if abs(self.along) > config.steepest or not config.radii[0] < abs(self.rho) / slope < config.radii[1]:
            return None
        return "sphere" if self.axis is None else "cylinder" if abs(self.along) < config.upright else "cone"


def rounded(graph: PatchGraph, config: FacetedConfig = FacetedConfig()) -> tuple[PatchGraph, dict[int, int]]:
    """The graph with one round face for the flats of each ring or ball, and whose ids it has taken."""
    faces, gone = list(graph.faces), dict[int, int]()
    while (found := _largest(_flats(faces, config), config)) is not None:
        made = _made(*found, faces, config)
        if made is None:
            break
        whole, taken = made
        gone |= {old: whole.id for old in taken if old != whole.id}
        faces = [whole if face.id == whole.id else face for face in faces if face.id not in gone]
    eased = [_eased(face, config) for face in faces]
    changed = any(face is not own for face, own in zip(faces, eased, strict=True))
    faces = eased
    while (twins := _twins(faces, config)) is not None:
        whole, other = twins
        gone = {old: whole.id if new == other else new for old, new in gone.items()} | {other: whole.id}
        faces = [whole if face.id == whole.id else face for face in faces if face.id != other]
    return (replace(graph, faces=tuple(faces)) if gone or changed else graph), gone


def _eased(face: Face, config: FacetedConfig) -> Face:
    """The face, fitted by where it was felt, if its normals disagree as those of facets do that a pad spans."""
    felt = face.contacts
    if not _is_round(face, config) or not isinstance(face.fit, Fit):
        return face
    lean = np.arccos(
        np.clip(np.abs((face.fit.shape.normals(felt.points) * felt.normals).sum(axis=1)), 0.0, 1.0)
    )
    if not float(np.median(lean / felt.normal_sigma)) > config.leaning:
        return face
    found = fit(face.fit.kind, replace(felt, normal_sigma=frozen(np.full(len(felt), config.aside))))
    alike = isinstance(found, Fit) and found.convex == face.fit.convex and found.rms < config.twin
    if not isinstance(found, Fit) or not alike:
        return face
    return replace(face, fit=found, contacts=_each_alone(felt), ranked=())


def _twins(faces: Sequence[Face], config: FacetedConfig) -> tuple[Face, int] | None:
    """One face for two round ones that lie in each other, and the id of the one that it has taken."""
    some = [face for face in faces if _is_round(face, config)]
    for one, other in permutations(some, 2):
        if len(one.contacts) < len(other.contacts) or not _lies_in(other, one, config):
            continue
        both = Contacts.concatenate([one.contacts, other.contacts])
        eased = (
            frozen(np.maximum(both.sigma, config.twin)),
            frozen(np.maximum(both.normal_sigma, config.aside)),
        )
        found = fit(_fit_of(one).kind, replace(both, sigma=eased[0], normal_sigma=eased[1]))
        if isinstance(found, Fit) and found.convex == _fit_of(one).convex and found.rms < config.twin:
            return Face(one.id, found, _each_alone(both)), other.id
    return None


def _lies_in(other: Face, one: Face, config: FacetedConfig) -> bool:
    """Whether most contacts of a face lie as those of another do, and among them."""
    own, shape = _fit_of(one), _fit_of(one).shape
    if own.kind != _fit_of(other).kind or own.convex != _fit_of(other).convex:
        return False
    felt, side = other.contacts, 1.0 if own.convex else -1.0
    near: Bools = np.abs(shape.signed_distance(felt.points)) < config.on
    alike: Bools = (side * shape.normals(felt.points) * felt.normals).sum(axis=1) > np.cos(config.aside)
    among = KDTree(one.contacts.points).query(felt.points)[0] < config.among
    return float(np.mean(near & alike)) > config.mostly and float(np.mean(among)) > config.mixed


def _is_round(face: Face, config: FacetedConfig) -> bool:
    """Whether a face is round, and was felt well."""
    many = int((face.contacts.touch != NOT_FELT).sum()) >= config.many
    return isinstance(face.fit, Fit) and face.fit.kind in _ROUND and many


def _fit_of(face: Face) -> Fit:
    assert isinstance(face.fit, Fit)
    return face.fit


def _flats(faces: Sequence[Face], config: FacetedConfig) -> _Flats:
    """The flat faces that were felt well enough to tell how they stand."""
    flat = tuple(
        face
        for face in faces
        if isinstance(face.fit, Fit)
        and face.fit.kind == "plane"
        and int((face.contacts.touch != NOT_FELT).sum()) >= config.contacts
    )
    fits = [face.fit for face in flat if isinstance(face.fit, Fit)]
    normals = np.array([own.shape.direction * (1.0 if own.convex else -1.0) for own in fits]).reshape(-1, 3)
    anchors = np.array([own.shape.anchor for own in fits]).reshape(-1, 3)
    return _Flats(flat, normals, (normals * anchors).sum(axis=1))


def _largest(flats: _Flats, config: FacetedConfig) -> tuple[_Flats, _Round] | None:
    """What most flats are tangents of, and those; a ball is one where it has more of them than any ring."""
    turn = np.arccos(np.clip(flats.normals @ flats.normals.T, -1.0, 1.0))
    beside = (turn > config.turns[0]) & (turn < config.turns[1])
    best: tuple[_Flats, _Round] | None = None
    most = 0
    for of, few, least in ((_Round.ring, 2, config.least), (_Round.ball, 3, config.least_ball)):
        for rows in _together(turn, few, config) if beside.any(axis=1).sum() >= least else ():
            first = of(flats.normals[rows], flats.offsets[rows])
            held = first.holds(flats, config.near, 2.0 * config.same)
            if held.sum() < max(least, most + 1):
                continue
            whole = of(flats.normals[held], flats.offsets[held])
            held &= whole.holds(flats, config.off, config.same)
            held &= (beside & held).any(axis=1)  # facets come one after the other
            if held.sum() >= max(least, most + 1) and whole.kind(config) is not None:
                own = tuple(face for face, mine in zip(flats.faces, held, strict=True) if mine)
                best = _Flats(own, flats.normals[held], flats.offsets[held]), whole
                most = len(own)
    return best


def _together(turn: Floats, few: int, config: FacetedConfig) -> Iterator[list[int]]:
    """A flat and so few of those round it; `turn` [rad] is from each to each."""
    for middle, away in enumerate(turn):
        order = np.argsort(away)
        near = order[(away[order] > config.turns[0]) & (away[order] < 2.0 * config.turns[1])]
        some = (
            near[np.unique(np.linspace(0, len(near) - 1, config.tried).astype(np.int64))]
            if len(near)
            else near
        )
        for others in combinations(some.tolist(), few):
            yield [middle, *others]


def _made(
    own: _Flats, whole: _Round, faces: Sequence[Face], config: FacetedConfig
) -> tuple[Face, list[int]] | None:
    """The round face of some facets and of what else was felt of it, and the ids of all those."""
    kind, step = whole.kind(config) or "", _step(own.normals, config)
    first = max(own.faces, key=lambda face: len(face.contacts))
    taken, felt = list(own.faces), Contacts.concatenate([face.contacts for face in own.faces])
    found = _fitted(kind, felt, step)
    if found is None or found.convex != (whole.rho > 0.0):
        return None
    bulge, side = _bulge(found, felt, step), 1.0 if found.convex else -1.0
    for face in faces:
        if isinstance(face.fit, Fit) and all(face is not other for other in taken):
            near = np.abs(found.shape.signed_distance(face.contacts.points)) < bulge + config.on
            cosine = (side * found.shape.normals(face.contacts.points) * face.contacts.normals).sum(axis=1)
            alike = np.arccos(np.clip(cosine, -1.0, 1.0)) < 0.5 * step + config.aside
            if float((near & alike).mean()) > config.mostly:
                taken.append(face)
    every = Contacts.concatenate([face.contacts for face in taken])
    found = _fitted(kind, every, step)
    if found is None or not config.radii[0] < _radius(found, every) < config.radii[1]:
        return None
    return Face(first.id, found, _each_alone(every)), [face.id for face in taken]


def _step(normals: Floats, config: FacetedConfig) -> float:
    """[rad] from a facet to the next, for the most part."""
    turn = np.arccos(np.clip(normals @ normals.T, -1.0, 1.0))
    return float(np.median(np.where(turn > config.turns[0], turn, np.inf).min(axis=1)))


def _fitted(kind: str, felt: Contacts, step: float) -> Fit | None:
    """The shape through all facets: what they are flat by is what their contacts may err by."""
    first = fit(kind, replace(felt, normal_sigma=frozen(np.full(len(felt), step))))
    if not isinstance(first, Fit):
        return None
    eased = replace(
        felt,
        sigma=frozen(np.maximum(felt.sigma, 0.5 * _bulge(first, felt, step))),
        normal_sigma=frozen(np.maximum(felt.normal_sigma, 0.5 * step)),
    )
    found = fit(kind, eased)
    return found if isinstance(found, Fit) else None


def _each_alone(felt: Contacts) -> Contacts:
    """The contacts as touches of their own: what those of one facet are off by together is no error of a stage."""
    return replace(felt, touch=frozen(_ALONE + np.arange(len(felt)), np.int64))


def _bulge(found: Fit, felt: Contacts, step: float) -> float:
    """[mm] that a facet's corners lie farther out than its middle."""
    return _radius(found, felt) * (1.0 / float(np.cos(0.5 * step)) - 1.0)


def _radius(found: Fit, felt: Contacts) -> float:
    """[mm] of a round face, where it was felt in the mean."""
    away = felt.points - found.shape.anchor
    if not isinstance(found.shape, Sphere):
        axis = found.shape.direction
        away = away - np.outer(away @ axis, axis)
    return float(np.mean(np.sqrt((away * away).sum(axis=1))))
