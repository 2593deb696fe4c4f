"""By how much contacts of one face disagree beyond their own sigmas, as the stage that carried the pad makes them.

What the faces so far tell of it is `touch_errors`.  Contacts held to be of no face count as those of the one that
they lie beside, or errors larger than was believed could never show.  Where the readings of a touch, and the
touches of a face, scatter as little as on an exact stage nothing more is asked.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain

import numpy as np

from primitives.arrays import Bools, Floats
from primitives.evidence import Contacts
from primitives.fit import Fit
from primitives.patch_graph import PatchGraph
from primitives.touch_equations import first_of_readings
from primitives.touch_errors import touch_errors

_EXACT = 0.015  # [mm] of scatter that fits allow for as it is
_MOST = 0.3  # [mm] beyond which faces and not the stage are wrong
_BESIDE = 0.4  # [mm] from a face, within which contacts that none explains may be of it
_FACING = 0.998  # least cosine between their normals and its own
_LEAST = 3  # readings of a touch, or touches, that tell how they scatter
_NORMAL = 1.48  # standard deviations of a normal distribution to its median distance


@dataclass(frozen=True)
class _Touched:
    """A fit, and all contacts that may be of it."""

    fit: Fit
    contacts: Contacts

    def readings(self) -> list[tuple[Floats, float]]:
        """How far the readings of each touch lie off the face, and their own sigma [mm]."""
        c, off = self.contacts, self.fit.shape.signed_distance(self.contacts.points)
        starts = first_of_readings(c)
        means = np.add.reduceat(off, starts) / np.diff([*starts, len(off)])
        of = c.touch[starts]
        return [(means[of == touch], float(np.median(c.sigma[c.touch == touch]))) for touch in np.unique(of)]


def scatter_of(graph: PatchGraph, loose: Contacts) -> float:
    """[mm] the standard deviation that stage and touches add to every contact; 0 on an exact stage."""
    faces = [
        _Touched(
            face.fit,
            Contacts.concatenate([face.contacts, loose.select(_beside(face.fit, face.contacts, loose))]),
        )
        for face in graph.faces
        if isinstance(face.fit, Fit) and len(face.contacts)
    ]
    if not faces or _agree(faces):
        return 0.0
    errors = touch_errors(faces)
    return 0.0 if errors is None else min(float(np.hypot(errors.reading, errors.touch)), _MOST)


def _agree(faces: list[_Touched]) -> bool:
    """Whether most readings and touches scatter no more than their own sigmas and an exact stage explain."""
    told = [face.readings() for face in faces]
    within = [_beyond(float(off.std(ddof=1)), own) for off, own in chain(*told) if len(off) >= _LEAST]
    between = [
        _beyond(_NORMAL * abs(float(off.mean())), own)
        for touches in told
        if len(touches) > 1
        for off, own in touches
    ]
    reading = float(np.median(within)) if len(within) >= _LEAST else 0.0
    touch = float(np.median(between)) if len(between) >= _LEAST else 0.0
    return float(np.hypot(reading, touch)) < _EXACT


def _beyond(scatter: float, own: float) -> float:
    return float(np.sqrt(max(0.0, scatter**2 - own**2)))


def _beside(fit: Fit, felt: Contacts, loose: Contacts) -> Bools:
    """(n,) which loose contacts may be of a face after all: they lie on it where it was felt, and face alike."""
    side = 1.0 if fit.convex else -1.0
    near = np.abs(fit.shape.signed_distance(loose.points)) < _BESIDE
    facing = side * (fit.shape.normals(loose.points) * loose.normals).sum(axis=1) > _FACING
    reach = np.linalg.norm(felt.points - felt.points.mean(axis=0), axis=1).max()
    inside = np.linalg.norm(loose.points - felt.points.mean(axis=0), axis=1) < reach
    return np.asarray(near & facing & inside)
