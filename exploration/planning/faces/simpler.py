"""Faces whose shape only a few stray contacts ask for.

A pad that lay half on a rounded corner leaves contacts that bend a flat side into a wide cone.  A robust fit of a
simpler kind leaves them out: where it keeps nearly all contacts, and lies as near to those as the face's own shape
does, the strays are all that the other shape explains.  Of a real cone or ring no plane or cylinder keeps half
(our derivation).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from primitives.arrays import Floats
from primitives.fit import Fit, FitOptions, fit
from primitives.patch_graph import Face, PatchGraph

_BENT = "cone", "torus"  # kinds that strays make of others
_SIMPLER = "plane", "cylinder"
_FEW = 12  # contacts, from which most can be told from strays
_KEPT = 0.93  # share of them that the simpler shape must keep
_AS_NEAR = 1.1  # times the distance of these from the face's own shape
_ROBUST = FitOptions(robust=True, gain=1e-5, iterations=15, starts=2)


def simpler(graph: PatchGraph) -> PatchGraph:
    """The graph with planes and cylinders for cones and rings that no more than strays ask for."""
    return replace(graph, faces=tuple(_simpler(face) for face in graph.faces))


def _simpler(face: Face) -> Face:
    own = face.fit
    if not isinstance(own, Fit) or own.kind not in _BENT or len(face.contacts) < _FEW:
        return face
    for kind in _SIMPLER:
        found = fit(kind, face.weighed, _ROBUST)
        if not isinstance(found, Fit) or found.inliers.mean() < _KEPT:
            continue
        near = _rms(own, face.contacts.points[found.inliers])
        if _rms(found, face.contacts.points[found.inliers]) < _AS_NEAR * near:
            return replace(face, fit=found, ranked=())
    return face


def _rms(found: Fit, points: Floats) -> float:
    """[mm] of (n, 3) points from a fit's shape."""
    return float(np.sqrt(np.mean(found.shape.signed_distance(points) ** 2)))
