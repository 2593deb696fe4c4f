"""A convex body lies behind each of its faces; a face that others' contacts contradict was none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from primitives.fit import Fit
from primitives.patch_graph import PatchGraph

_BEYOND = 0.3  # [mm] a contact this far in front of a face contradicts it
_SHARE = 0.1  # of a face's own contacts, that as many against it outweigh
_MOST = 3  # contradicting contacts that are put down to noise


def drop_contradicted(graph: PatchGraph) -> PatchGraph:
    """The graph less its faces that too many contacts contradict, the worst first."""
    while True:
        worst = _worst(graph)
        if worst is None:
            return graph
        faces = tuple(face for face in graph.faces if face.id != worst)
        edges = tuple(edge for edge in graph.edges if worst not in edge.faces)
        graph = replace(graph, faces=faces, edges=edges)


def _worst(graph: PatchGraph) -> int | None:
    against: dict[int, float] = {}
    for face in graph.faces:
        if not isinstance(face.fit, Fit):
            continue
        others = [f.contacts.points for f in graph.faces if f.id != face.id]
        if not others:
            continue
        points = np.concatenate(others)
        distance = face.fit.shape.signed_distance(points)
        beyond = int((distance * (1.0 if face.fit.convex else -1.0) > _BEYOND).sum())
        if beyond > _MOST and beyond > _SHARE * len(face.contacts):
            against[face.id] = beyond / len(face.contacts)
    return max(against, key=lambda face_id: against[face_id], default=None)
