"""Faces that were found without normals, told apart into inside and outside, and their contacts given normals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from primitives.arrays import Floats, frozen
from primitives.evidence import Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face, PatchGraph
from primitives.segmentation.neighbors import lifted, linked, nearest
from primitives.segmentation.senses import senses

_LOOKED_AT = 1500  # contacts that tell the senses
_LINKS = 8  # neighbors of each
_SIGMA = 0.05  # [rad] of a normal that is its face's


def turned_out(graph: PatchGraph) -> PatchGraph:
    """The graph with each face's sense as felt, or as all faces together have it."""
    fitted = [(face, face.fit) for face in graph.faces if isinstance(face.fit, Fit)]
    if not fitted:
        return graph
    of = np.repeat(np.arange(len(fitted)), [len(face.contacts) for face, _ in fitted])
    points = np.concatenate([face.contacts.points for face, _ in fitted])
    normals = np.concatenate([fit.shape.normals(face.contacts.points) for face, fit in fitted])
    known = np.array([_as_felt(face.contacts, fit) for face, fit in fitted])
    some = np.random.default_rng(0).permutation(len(points))[:_LOOKED_AT]
    links = linked(nearest(lifted(points[some], normals[some]), min(_LINKS + 1, len(some)))[1])
    sense = senses(points[some], normals[some], of[some], known, links)
    turned = [_turned(face, fit, float(s)) for (face, fit), s in zip(fitted, sense, strict=True)]
    nameless = (face for face in graph.faces if not isinstance(face.fit, Fit))
    return PatchGraph((*turned, *nameless), options=graph.options)


def _as_felt(contacts: Contacts, fit: Fit) -> float:
    """1 or -1 where normals were felt, else 0."""
    return (1.0 if fit.convex else -1.0) if contacts.has_normal.any() else 0.0


def _turned(face: Face, fit: Fit, sense: float) -> Face:
    contacts, felt = face.contacts, face.contacts.has_normal
    own: Floats = sense * fit.shape.normals(contacts.points)
    table = replace(
        contacts,
        normals=frozen(np.where(felt[:, None], contacts.normals, own)),
        normal_sigma=frozen(np.where(felt, contacts.normal_sigma, _SIGMA)),
    )
    return replace(face, fit=replace(fit, convex=sense > 0), contacts=table)
