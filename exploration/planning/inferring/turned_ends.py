"""Flat ends of turned faces, inferred from rims that run round their axis.

A cylinder or cone that ends at a rim round its axis was most likely turned, and what ends it stands upright on the
axis there: a narrow ring, on which no array can lie, does so on a funnel's mouth or a pipe's end.  That is likely
and not measured, so the end is marked as inferred (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exploration.control.sighting import Sighting
from primitives import pose as se3
from primitives.arrays import Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.shapes import Cone, Cylinder


@dataclass(frozen=True)
class TurnedEndsConfig:
    """When a rim is of an end, and where its contacts are."""

    round: float = 0.1  # most cosine between a rim and the axis that it runs round
    away: float = 0.3  # least cosine between the way out of the face and the axis
    same: float = 0.6  # [mm] between the heights of rims of one end
    arc: float = 0.3  # [rad] to either side of a rim, where its end is
    deep: tuple[float, ...] = (0.3, 0.8, 1.3)  # [mm] from a rim, likewise
    sigma: float = 0.1  # [mm]
    normal_sigma: float = 0.02  # [rad]


def turned_ends(
    rims: Sequence[tuple[Sighting, int]], faces: Sequence[Face], config: TurnedEndsConfig = TurnedEndsConfig()
) -> list[Contacts]:
    """Contacts of each end that rims tell of; each rim comes with the id of its face."""
    ends: list[tuple[Floats, Floats]] = []
    shapes = {face.id: face.fit.shape for face in faces if isinstance(face.fit, Fit)}
    for rim, own in rims:
        shape = shapes.get(own)
        if not isinstance(shape, Cylinder | Cone):
            continue
        axis, out = shape.direction, float(shape.direction @ rim.outward)
        if abs(float(axis @ rim.tangent)) > config.round or abs(out) < config.away:
            continue
        way, places = axis * np.sign(out), _places(rim, shape, config)
        for k, (others, known) in enumerate(ends):
            if (
                way @ known > 0.99
                and abs(float((others.mean(axis=0) - places.mean(axis=0)) @ way)) < config.same
            ):
                ends[k] = np.concatenate([others, places]), known
                break
        else:
            ends.append((places, way))
    return [
        Contacts.of(p, np.broadcast_to(way, p.shape), config.sigma, config.normal_sigma, touch=NOT_FELT)
        for p, way in ends
    ]


def _places(rim: Sighting, shape: Cylinder | Cone, config: TurnedEndsConfig) -> Floats:
    """(n, 3) places of the end beside a rim, on the material's side of it."""
    axis = shape.direction
    inward = (rim.normal @ axis) * axis - rim.normal
    beside = rim.point + np.outer(config.deep, inward / np.linalg.norm(inward))
    turns = [se3.turn_about(shape.anchor, axis, angle) for angle in (-config.arc, 0.0, config.arc)]
    return np.concatenate([se3.transform_points(turn, beside) for turn in turns])
