"""By how much contacts of one face disagree beyond their own sigmas, as the stage that carried the pad makes them.

A stage that errs puts each reading a little off, and every touch.  The faces so far tell by how much: how the
readings of a touch scatter about their mean, and how far the touches of a face lie apart; the medians of these, so
that a few which lie on no such face say nothing.  Contacts held to be of no face count as touches of the one that
they lie beside, or errors larger than was believed could never show.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from primitives.arrays import Bools, Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face, PatchGraph

_BESIDE = 0.4  # [mm] from a face, within which contacts that none explains may be of it
_FACING = 0.998  # least cosine between their normals and its own
_LEAST = 3  # readings of a touch that tell how they scatter, and touches that tell how they do
_NORMAL = 1.48  # standard deviations of a normal distribution to its median distance


def scatter_of(graph: PatchGraph, loose: Contacts) -> float:
    """[mm] the standard deviation that stage and touches add to every contact; 0 while too few tell."""
    within: list[float] = []
    between: list[float] = []
    for face in graph.faces:
        if not isinstance(face.fit, Fit):
            continue
        own = list(_touches(face.fit, face.contacts))
        lost = list(_touches(face.fit, loose.select(_beside(face, face.fit, loose))))
        within.extend(float(off.std(ddof=1)) for off in own if len(off) >= _LEAST)
        count = len(own) + len(lost)
        if count > 1:
            grown = np.sqrt(count / (count - 1))
            between.extend(grown * abs(float(off.mean())) for off in (*own, *lost))
    reading = float(np.median(within)) if len(within) >= _LEAST else 0.0
    touch = _NORMAL * float(np.median(between)) if len(between) >= _LEAST else 0.0
    return float(np.hypot(reading, touch))


def _touches(fit: Fit, contacts: Contacts) -> Iterator[Floats]:
    """How far the readings of each touch lie off the face [mm]; those of a frame have one normal."""
    if not len(contacts):
        return
    off = fit.shape.signed_distance(contacts.points)
    alike = (contacts.normals[1:] == contacts.normals[:-1]).all(axis=1)
    starts = np.flatnonzero(np.concatenate([[True], ~(alike & (contacts.touch[1:] == contacts.touch[:-1]))]))
    means = np.add.reduceat(off, starts) / np.diff([*starts, len(off)])
    touch = contacts.touch[starts]
    for one in np.unique(touch[touch != NOT_FELT]):
        yield means[touch == one]


def _beside(face: Face, fit: Fit, loose: Contacts) -> Bools:
    """(n,) which loose contacts may be of a face after all: over where it was felt, and facing as it does."""
    side = 1.0 if fit.convex else -1.0
    near = np.abs(fit.shape.signed_distance(loose.points)) < _BESIDE
    facing = side * (fit.shape.normals(loose.points) * loose.normals).sum(axis=1) > _FACING
    low, high = face.contacts.points.min(axis=0) - _BESIDE, face.contacts.points.max(axis=0) + _BESIDE
    inside = ((loose.points > low) & (loose.points < high)).all(axis=1)
    return np.asarray(near & facing & inside)
