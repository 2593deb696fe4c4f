"""Contacts of no face that lie round a known axis: a boss or a bore of which two touches alone tell.

Few contacts of two touches fit many shapes.  Of those whose normals all lead to, or away from, an axis that the
object has already, at one distance, no other shape than a cylinder round it is likely (our derivation).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from exploration.planning.faces.uprighted import drawn_out
from primitives.arrays import Floats, frozen
from primitives.evidence import Contacts
from primitives.fit import Fit, fit
from primitives.patch_graph import Face, PatchGraph
from primitives.shapes import Cone, Cylinder


@dataclass(frozen=True)
class CoaxialConfig:
    """When contacts are of one cylinder round an axis."""

    level: float = 0.1  # most cosine between their normals and the axis,
    radial: float = 0.99  # and least of those with the way out of it
    apart: float = 0.25  # [mm] of their distances from the axis from each other
    contacts: int = 6  # of them at least,
    touches: int = 2  # in so many touches,
    turn: float = 0.5  # [rad] round the axis, that these lie apart


def coaxial_face(graph: PatchGraph, loose: Contacts, config: CoaxialConfig = CoaxialConfig()) -> Face | None:
    """The cylinder round a known axis that most loose contacts are of; None where too few are."""
    best: tuple[int, Fit, Contacts] | None = None
    for axis, anchor in _axes(graph):
        away = loose.points - anchor
        away = away - np.outer(away @ axis, axis)
        far = np.linalg.norm(away, axis=1)
        out = (loose.normals * away).sum(axis=1) / np.maximum(far, 1e-9)
        for side in (1.0, -1.0):
            level = np.abs(loose.normals @ axis) < config.level
            rows = np.flatnonzero(level & (side * out > config.radial))
            if not len(rows):
                continue
            middle = rows[np.argmax([(np.abs(far[rows] - far[k]) < config.apart).sum() for k in rows])]
            one = np.zeros(len(loose), dtype=bool)
            one[rows] = np.abs(far[rows] - far[middle]) < config.apart
            found = loose.select(one)
            if _enough(found, away[one], config) and (best is None or len(found) > best[0]):
                made = fit("cylinder", drawn_out(found, axis))
                if isinstance(made, Fit) and made.convex == (side > 0.0) and made.rms < config.apart:
                    best = len(found), made, found
    if best is None:
        return None
    number = graph.next_id
    count, made, found = best
    return Face(number, replace(made, inliers=frozen(np.ones(count), bool)), found)


def _axes(graph: PatchGraph) -> Iterator[tuple[Floats, Floats]]:
    """(3,) axes of the round faces, and a (3,) point on each."""
    for face in graph.faces:
        if isinstance(face.fit, Fit) and isinstance(face.fit.shape, Cylinder | Cone):
            yield face.fit.shape.axis, face.fit.shape.anchor


def _enough(found: Contacts, away: Floats, config: CoaxialConfig) -> bool:
    touches = np.unique(found.touch)
    if len(found) < config.contacts or len(touches) < config.touches:
        return False
    ways = np.array([away[found.touch == touch].mean(axis=0) for touch in touches])
    ways = ways / np.linalg.norm(ways, axis=1)[:, None]
    return bool((ways @ ways.T).min() < np.cos(config.turn))
