"""The rims of narrow holes that frames showed, on the flat faces that they are in."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from exploration.planning.known.seen_pits import SeenPit
from exploration.planning.open.known_face import KnownFace
from exploration.planning.open.round_rims import RoundRim

_LIES = 0.5  # [mm] of a pit's middle from its face
_FACES = 0.98  # least cosine between the face's normal and the way that the pad lay
_FELT = 6.0  # [mm] from a pit's rim, within which its face was touched
_SIGMA = 0.4  # [mm] of a radius told by an area


def pit_rims(seen: Sequence[SeenPit], known: Sequence[KnownFace]) -> list[RoundRim]:
    """One for each pit that lies in a known flat face."""
    return [rim for pit in seen if (rim := _rim(pit, known)) is not None]


def _rim(pit: SeenPit, known: Sequence[KnownFace]) -> RoundRim | None:
    at = pit.center[None]
    for own in known:
        if own.fit.kind != "plane" or not len(own.cells):
            continue
        axis = own.side * own.fit.shape.direction
        off = float(own.fit.shape.signed_distance(at)[0])
        if abs(off) > _LIES or float(axis @ pit.normal) < _FACES:
            continue
        if float(own.near.query(pit.center)[0]) < pit.radius + _FELT:
            foot = np.asarray(own.fit.shape.project(at)[0])
            return RoundRim(foot, axis, pit.radius, _SIGMA, own.face.id)
    return None
