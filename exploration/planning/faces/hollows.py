"""Hollows that one touch was in: a few clean contacts across a direction that the object has.

A fingertip in a scallop leaves three or four contacts, too few for a face of any kind.  Where they face three ways
or more, all of them across one of the object's directions, and lie on one cylinder along it, facing its axis, they
are of that: no edge and no corner reads as hollow (our derivation).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from exploration.planning.faces.uprighted import drawn_out
from primitives.arrays import Floats, frozen
from primitives.evidence import Contacts
from primitives.fit import Fit, fit
from primitives.patch_graph import Face, PatchGraph
from primitives.shapes import Cylinder, Sphere


@dataclass(frozen=True)
class HollowsConfig:
    """When contacts of a touch are of a hollow."""

    level: float = 0.05  # most cosine between their normals and its axis
    contacts: int = 4  # of them at least,
    ways: int = 3  # that face so many ways
    apart: float = 0.1  # [rad] from each other
    off: float = 0.06  # [mm] of each from the cylinder at most,
    facing: float = 0.995  # and least cosine of its normal with that of the cylinder
    radii: tuple[float, float] = (4.0, 60.0)  # [mm]


def hollow_face(graph: PatchGraph, loose: Contacts, config: HollowsConfig = HollowsConfig()) -> Face | None:
    """The hollow that one of the touches of which contacts are loose was in; None where none was."""
    axes = _axes(graph)
    for touch in np.unique(loose.touch):
        lot = loose.select(loose.touch == touch)
        for axis in axes:
            level = lot.select(np.abs(lot.normals @ axis) < config.level)
            made = _hollow(level, axis, config)
            if made is not None:
                number = graph.next_id
                return Face(number, replace(made, inliers=frozen(np.ones(len(level)), bool)), level)
    return None


def _axes(graph: PatchGraph) -> list[Floats]:
    """(3,) directions of the faces, each once."""
    found: list[Floats] = []
    for face in graph.faces:
        if isinstance(face.fit, Fit) and not isinstance(face.fit.shape, Sphere):
            way = face.fit.shape.direction
            if all(abs(float(way @ other)) < 1.0 - 1e-4 for other in found):
                found.append(way)
    return found


def _hollow(lot: Contacts, axis: Floats, config: HollowsConfig) -> Fit | None:
    if len(lot) < config.contacts or _ways(lot.normals, config) < config.ways:
        return None
    made = fit("cylinder", drawn_out(lot, axis))
    if not isinstance(made, Fit) or made.convex or not isinstance(made.shape, Cylinder):
        return None
    off = np.abs(made.shape.signed_distance(lot.points)).max()
    facing = -(made.shape.normals(lot.points) * lot.normals).sum(axis=1).min()
    sized = config.radii[0] < made.shape.radius < config.radii[1]
    return made if sized and off < config.off and facing > config.facing else None


def _ways(normals: Floats, config: HollowsConfig) -> int:
    """How many of (n, 3) normals lie apart."""
    kept: list[Floats] = []
    for normal in normals:
        if all(float(normal @ other) < np.cos(config.apart) for other in kept):
            kept.append(normal)
    return len(kept)
