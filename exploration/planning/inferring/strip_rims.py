"""Rims at the ends of bars, ribs and posts, from where contact along their sides ends under the pad.

A pad that lies along something narrow and reaches past its end feels a strip that ends; where it does is told to
a tenth of a millimeter (`strip_end`), though no array has room to lie there or to roll over.  It is a rim of the
face that was felt, unless that was felt farther out (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exploration.control.sighting import Sighting
from exploration.planning.open.known_face import KnownFace
from exploration.planning.touching.findings import SeenRim


@dataclass(frozen=True)
class StripRimsConfig:
    """When contact has ended at a rim of a face."""

    on: float = 0.6  # [mm] from the face, at most,
    facing: float = 0.9  # and cosine between the ways that the two look, at least
    past: float = 2.0  # [mm] past the rim, from which the face was felt nowhere
    beside: float = 8.0  # [mm] aside,
    few: int = 3  # but for so many places


def strip_rims(
    ends: Sequence[Sighting], known: Sequence[KnownFace], config: StripRimsConfig = StripRimsConfig()
) -> list[SeenRim]:
    """Each rim that narrow contacts were felt to end at, with the id of the face that ends there."""
    found = []
    for end in ends:
        own = min(
            (face for face in known if _faces_alike(end, face, config)),
            key=lambda face: _off(end, face),
            default=None,
        )
        if own is not None and _off(end, own) < config.on and not _goes_on(end, own, config):
            found.append((end, own.face.id))
    return found


def _off(end: Sighting, own: KnownFace) -> float:
    return abs(float(own.fit.shape.signed_distance(end.point[None])[0]))


def _faces_alike(end: Sighting, own: KnownFace, config: StripRimsConfig) -> bool:
    return own.side * float(own.fit.shape.normals(end.point[None])[0] @ end.normal) > config.facing


def _goes_on(end: Sighting, own: KnownFace, config: StripRimsConfig) -> bool:
    """Whether the face was felt past the rim."""
    away = own.cells - end.point
    near = np.abs(away @ end.tangent) < config.beside
    return int((near & (away @ end.outward > config.past)).sum()) > config.few
