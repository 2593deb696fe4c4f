"""The ball that holds the object, as far as is believed: approaches begin outside it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from exploration.planning.ways.round_ball import Ball
from models.library import Library
from models.solid import Solid
from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.pose import inverse, transform_points
from recognition.matching import Belief
from recognition.matching.next_touch.held import Held, held


@dataclass(frozen=True)
class BoundsConfig:
    """How far away to keep."""

    margin: float = 12.0  # [mm] round the ball that holds the object
    held_share: float = 0.99  # of the belief, whose objects the ball must hold
    widest: float = 1.6  # times the largest object of the library: no ball is larger without a contact there


def believed_ball(
    felt: Contacts,
    met: int,
    belief: Belief | None,
    library: Library,
    pad: tuple[float, float],
    config: BoundsConfig | None = None,
    known: Held | None = None,
) -> Ball:
    """Round what is believed after `met` touches that met something; never smaller than what was felt.

    `known` are poses drawn from the belief, where there are any: they span less than its modes' balls do.
    """
    config = config or BoundsConfig()
    widest = largest(library)
    middle, radius = felt.points.mean(axis=0), widest
    drawn = known is not None
    if known is None and belief is not None:
        known = held(belief, library)
    if known is not None and len(known) and known.unknown < 0.5:
        share = known.weights / known.weights.sum()
        middle = share @ known.centers
        reach = np.linalg.norm(known.centers - middle, axis=1) + known.radii
        if drawn:
            reach = np.array([_farthest(middle, solid) for solid in known.solids])
        order = np.argsort(reach)
        enough = np.cumsum(share[order]) >= config.held_share
        radius = float(reach[order][min(int(np.argmax(enough)), len(order) - 1)])
    elif felt.has_normal.any() and met < 3:
        middle = middle - 0.5 * radius * np.nanmean(felt.normals, axis=0)
    radius = min(radius, config.widest * widest)
    farthest = float(np.linalg.norm(felt.points - middle, axis=1).max(initial=0.0))
    return Ball(middle, max(radius, farthest) + config.margin + 0.5 * max(pad))


def _farthest(middle: Floats, solid: Solid) -> float:
    """[mm] from a (3,) point to the corner of a posed solid that is farthest away."""
    there = transform_points(inverse(solid.pose), middle[None])
    return float(np.linalg.norm(solid.body.vertices - there, axis=1).max())


def felt_ball(
    felt: Contacts, library: Library, pad: tuple[float, float], config: BoundsConfig | None = None
) -> Ball:
    """Behind what was felt, whatever is believed: where touching does not fail for a wrong belief."""
    config = config or BoundsConfig()
    widest = largest(library)
    middle = felt.points.mean(axis=0)
    if felt.has_normal.any():
        middle = middle - 0.15 * widest * np.nanmean(felt.normals, axis=0)
    return Ball(middle, config.widest * widest + config.margin + 0.5 * max(pad))


def largest(library: Library) -> float:
    """[mm] half the diagonal of the largest object."""
    return max(0.5 * float(np.linalg.norm(entry.solid.extent)) for entry in library.values())
