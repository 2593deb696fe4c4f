"""Round faces of which an array felt the facets, taken together.

Who turns a cylinder, cone or ball into a coarse mesh gives it many narrow sides, and a pad that is wider than one
of them lies flat on it.  Flats that are tangents of one round face (`tangents`) are that face, with what pads made
of two of them: who means so many sides means what is round.  Where the rest of the object was felt between them,
far from it, as the teeth of a gear are, there is no such face (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial import KDTree

from exploration.planning.faces.spanned import alone, along_axis, fit_of, off_facets, put_in, spanned
from exploration.planning.faces.tangents import Flats, Round, TangentsConfig, flats_of, largest, step_of
from primitives.arrays import frozen
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit, fit
from primitives.patch_graph import Face, PatchGraph
from primitives.shapes import Sphere
from primitives.starts import ball_through

_LOOKED = 2  # times for pieces of a face: with the first of them it is known better


@dataclass(frozen=True)
class FacetedConfig:
    """When flats are facets of a round face, and what else is of it."""

    tangents: TangentsConfig = field(default_factory=TangentsConfig)
    corners: float = 0.5  # of how far facets' corners lie out, that contacts may lie off the face, rms
    on: float = 0.25  # [mm] past the corners or middles, up to which a piece of it was felt that is no flat,
    aside: float = 0.1  # [rad] more than half a turn to the next, that this looks aside,
    mostly: float = 0.9  # and the share of its contacts, that do so
    before: float = 1.0  # [mm] past the corners or middles, from which what looks likewise
    likewise: float = 0.3  # [cosine] stands out of the face, or lies back,
    others: float = 0.2  # and as many times the contacts, of which there is no such face
    many: int = 8  # faces, that all may be of one ball:
    ball: float = 0.01  # of its radius, standard deviation from it of all contacts,
    leaning: float = 0.15  # [rad] that the median of their normals leans at most,
    covered: float = 0.1  # and the least variance of those along any way: they look all round


def rounded(graph: PatchGraph, config: FacetedConfig = FacetedConfig()) -> tuple[PatchGraph, dict[int, int]]:
    """The graph with one round face for the flats of each ring or ball, and whose ids it has taken.

    Round faces that pads made of several facets, or several of one, are made good as well (`spanned`).
    """
    faces, gone, refused = list(graph.faces), dict[int, int](), set[int]()
    while (taken := _one_more(faces, refused, config)) is not None:
        faces, gone = put_in(*taken, faces, gone)
    faces, twins = spanned(faces)
    gone = {old: twins.get(new, new) for old, new in gone.items()} | twins
    same = len(faces) == len(graph.faces) and all(a is b for a, b in zip(faces, graph.faces, strict=True))
    return (graph if same else replace(graph, faces=tuple(faces))), gone


def _one_more(
    faces: Sequence[Face], refused: set[int], config: FacetedConfig
) -> tuple[Face, list[int]] | None:
    """A round face, and the ids of those that are pieces of it; the flats that make none are `refused` then."""
    if (ball := _one_ball(faces, config)) is not None:
        return ball
    for whole in filter(off_facets, faces):
        step = 2.0 * float(np.median(whole.contacts.normal_sigma))
        if any(face is not whole and _is_piece(face, whole, step, config) for face in faces):
            more = _whole(fit_of(whole).kind, [whole], faces, step, config)
            if more is not None and len(more[1]) > 1:
                return more
    while (found := largest(flats_of(faces, refused, config.tangents), config.tangents)) is not None:
        made = _made(*found, faces, config)
        if made is not None:
            return made
        refused |= {face.id for face in found[0].faces}
    return None


def _one_ball(faces: Sequence[Face], config: FacetedConfig) -> tuple[Face, list[int]] | None:
    """The sphere that all that was felt is of, where pads that spanned its facets made many faces."""
    felt = Contacts.concatenate([face.contacts for face in faces])
    if len(faces) < config.many or not felt.has_normal.all() or (felt.touch == NOT_FELT).any():
        return None
    out = felt.points - ball_through(felt.points)[0]
    far = np.linalg.norm(out, axis=1)
    lean = np.arccos(np.clip(np.abs((out * felt.normals).sum(axis=1)) / np.maximum(far, 1e-9), 0.0, 1.0))
    round_ = float(far.std()) < config.ball * float(far.mean()) and float(np.median(lean)) < config.leaning
    all_round = float(np.linalg.eigvalsh(np.cov(felt.normals.T))[0]) > config.covered
    return _whole("sphere", faces, [], 2.0 * float(np.median(lean)), config) if round_ and all_round else None


def _made(
    own: Flats, whole: Round, faces: Sequence[Face], config: FacetedConfig
) -> tuple[Face, list[int]] | None:
    """The round face of some facets and of what else was felt of it, and the ids of all those."""
    kind, step = whole.kind(own.normals, config.tangents), step_of(own.normals, config.tangents)
    made = None if kind is None else _whole(kind, own.faces, faces, step, config)
    return made if made is not None and fit_of(made[0]).convex == (whole.rho > 0.0) else None


def _whole(
    kind: str, some: Sequence[Face], faces: Sequence[Face], step: float, config: FacetedConfig
) -> tuple[Face, list[int]] | None:
    """The round face that some are pieces of, with all that is one; None where much was felt off it."""
    taken, found = list(some), _fitted(kind, some, step)
    for _ in range(_LOOKED):
        if found is None:
            return None
        ids = [face.id for face in taken]
        taken += [f for f in faces if f.id not in ids and _is_piece(f, Face(-1, *found), step, config)]
        found = _fitted(kind, taken, step)
    if found is None or not config.tangents.radii[0] < _radius(*found) < config.tangents.radii[1]:
        return None
    ids = [face.id for face in taken]
    rest = Contacts.concatenate([face.contacts for face in faces if face.id not in ids])
    if found[0].rms > config.corners * _bulge(*found, step) + config.tangents.off:
        return None
    if _among_others(*found, rest, step, config):
        return None
    return Face(min(ids), found[0], alone(found[1], min(ids))), ids


def _is_piece(face: Face, whole: Face, step: float, config: FacetedConfig) -> bool:
    """Whether a face is one more facet, or what a pad made of two, beside the others."""
    if not isinstance(face.fit, Fit) or (face.contacts.touch == NOT_FELT).any():
        return False
    if along_axis(face.contacts, whole) < config.mostly:
        return False
    found, side = fit_of(whole), 1.0 if fit_of(whole).convex else -1.0
    off = np.abs(found.shape.signed_distance(face.contacts.points))
    cosine = (side * found.shape.normals(face.contacts.points) * face.contacts.normals).sum(axis=1)
    near = off < _bulge(found, whole.contacts, step) + config.on
    alike = np.arccos(np.clip(cosine, -1.0, 1.0)) < 0.5 * step + config.aside
    return float(np.mean(near & alike)) > config.mostly


def _among_others(found: Fit, felt: Contacts, rest: Contacts, step: float, config: FacetedConfig) -> bool:
    """Whether much of the `rest` stands out between facets, or lies back: a gear's teeth end in flats."""
    if not len(rest):
        return False
    shape, side = found.shape, 1.0 if found.convex else -1.0
    off = shape.signed_distance(rest.points)
    alike = (side * shape.normals(rest.points) * rest.normals).sum(axis=1) > config.likewise
    beside = KDTree(felt.points).query(shape.project(rest.points))[0] < step * _radius(found, felt)
    away = np.abs(off) > _bulge(found, felt, step) + config.before
    return int((alike & beside & away & (rest.touch != NOT_FELT)).sum()) > config.others * len(felt)


def _fitted(kind: str, faces: Sequence[Face], step: float) -> tuple[Fit, Contacts] | None:
    """The shape through all facets, and their contacts, which may err by what facets are flat by."""
    felt = Contacts.concatenate([face.contacts for face in faces])
    first = fit(kind, replace(felt, normal_sigma=frozen(np.full(len(felt), step))))
    if not isinstance(first, Fit):
        return None
    eased = replace(
        felt,
        sigma=frozen(np.maximum(felt.sigma, 0.5 * _bulge(first, felt, step))),
        normal_sigma=frozen(np.maximum(felt.normal_sigma, 0.5 * step)),
    )
    found = fit(kind, eased)
    return (found, eased) if isinstance(found, Fit) else None


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
