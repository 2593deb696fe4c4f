"""Round faces of few contacts, taken for cylinders along a direction that the object has already.

A pad that met a round end once or twice felt some ten contacts of it, or many on a narrow band.  They fit what
leans, a cone or a cylinder, as well as the cylinder that stands upright on its plate; what leans ends somewhere
else.  A cylinder along a known direction has three parameters, where a cone has six: Schwarz's criterion says what
the contacts pay for (our derivation).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from primitives.arrays import Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit, fit, squares
from primitives.patch_graph import Face, PatchGraph
from primitives.shapes import Cylinder

_FEW = 30  # contacts, from which a face tells its own direction
_BAND = 0.5  # of a cylinder's radius, along which it was felt at least where it tells its own direction
_PARAMETERS = 3  # of a cylinder along a given direction
_RESIDUALS = 3  # of a point with its normal
_SLACK = 3.0  # times chi2, by which contacts of one touch err together beyond their frames' noise
_ACROSS = 0.3  # most cosine between a direction and the median contact's normal
_STEP = 3.0  # [mm] along a cylinder, at which it is the same again
_SAME = 0.995  # cosine from which two directions are one
_UPRIGHT = 0.9998  # cosine from which a cylinder stands along a direction as it is


def uprighted(graph: PatchGraph) -> PatchGraph:
    """The graph with upright cylinders for its few-contact round faces, where their contacts allow it."""
    ways = list(_directions(graph))
    faces = []
    for face in graph.faces:
        found = _upright(face, ways)
        faces.append(face if found is None else replace(face, fit=found, ranked=()))
    return replace(graph, faces=tuple(faces))


def _directions(graph: PatchGraph) -> Iterator[Floats]:
    """(3,) normals and axes of the faces that tell theirs, each once."""
    found: list[Floats] = []
    for face in graph.faces:
        direction = getattr(face.fit.shape, "direction", None) if isinstance(face.fit, Fit) else None
        if direction is None or len(face.contacts) < _FEW or _narrow(face):
            continue
        if all(abs(direction @ other) < _SAME for other in found):
            found.append(direction)
            yield direction


def _upright(face: Face, ways: list[Floats]) -> Fit | None:
    """The cylinder along the direction that its contacts like best; None where its own fit explains more."""
    if not isinstance(face.fit, Fit) or face.fit.kind == "plane":
        return None
    if len(face.contacts) >= _FEW and not _narrow(face):
        return None
    felt = face.contacts.select(face.fit.inliers)
    if not len(felt) or (felt.touch == NOT_FELT).any() or not np.isfinite(felt.normals).all():
        return None
    shape = face.fit.shape
    if isinstance(shape, Cylinder) and any(abs(float(shape.direction @ way)) > _UPRIGHT for way in ways):
        return None
    paid = np.log(_RESIDUALS * len(felt))
    best, least = None, float(squares(face.fit, felt).sum()) / _SLACK + len(face.fit.sigma) * paid
    for way in ways:
        if np.median(np.abs(felt.normals @ way)) > _ACROSS:
            continue
        made = fit("cylinder", _drawn_out(felt, way))
        if not isinstance(made, Fit):
            continue
        own = squares(made, felt)
        score = float(own.sum()) / _SLACK + _PARAMETERS * paid
        if score < least:
            rows = face.fit.inliers
            dof = max(_RESIDUALS * len(felt) - _PARAMETERS, 1)
            best, least = replace(made, inliers=rows, chi2=float(own.sum()), dof=dof), score
    return best


def _narrow(face: Face) -> bool:
    """Whether a cylinder was felt on so narrow a band that its own blur turns its axis, as of a flange's rim."""
    shape = face.fit.shape if isinstance(face.fit, Fit) else None
    if not isinstance(shape, Cylinder):
        return False
    return float(np.ptp(face.contacts.points @ shape.axis)) < _BAND * shape.radius


def _drawn_out(felt: Contacts, way: Floats) -> Contacts:
    """The contacts, and the same again a step up and a step down a (3,) direction."""
    moved = [replace(felt, points=felt.points + step * way) for step in (0.0, _STEP, -_STEP)]
    return Contacts.concatenate(moved)
