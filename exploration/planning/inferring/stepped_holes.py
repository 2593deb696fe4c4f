"""Round holes whose two ends differ: counterbores, of which nothing is known but their rims.

Two rims on opposite faces that share an axis are of one hole.  Where one is wider, the hole narrows somewhere
between, most often at a flat ledge.  Where that lies nobody knows; half way is nearest to all that may be (our
derivation).  The sigma of its contacts does not say how far off that may be, the warning beside the model does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from exploration.planning.moves.round_holes import Hole
from exploration.planning.open.round_rims import RoundRim
from primitives.evidence import NOT_FELT, Contacts


@dataclass(frozen=True)
class SteppedHoleConfig:
    """When two rims are of one hole."""

    opposed: float = 0.98  # least cosine between the axes of its ends
    aside: float = 1.0  # [mm] of one end's center from the other's axis
    wider: float = 1.0  # [mm] between their radii, at least
    sigma: float = 0.5  # [mm] at most: what is less sure would be taken for the face round the mouth
    normal_sigma: float = 0.05  # [rad]


@dataclass(frozen=True)
class SteppedHole:
    """The wide part of a hole, down to a ledge."""

    rim: RoundRim  # its mouth
    hole: Hole
    ledge: Contacts  # nobody felt it


def stepped_holes(
    rims: Sequence[RoundRim],
    guessed: Sequence[RoundRim] = (),
    config: SteppedHoleConfig = SteppedHoleConfig(),
) -> list[SteppedHole]:
    """The wide end of every hole that becomes narrower; its far end may be one that is only guessed."""
    found = []
    for rim in rims:
        behind = [other for other in (*rims, *guessed) if _narrows(rim, other, config)]
        if not behind:
            continue
        other = min(behind, key=lambda b: float((rim.center - b.center) @ rim.axis))
        far = float((rim.center - other.center) @ rim.axis)
        hole = Hole(rim.center - 0.25 * far * rim.axis, rim.axis, rim.radius, 0.5 * far, rim.sigma)
        middle = replace(
            rim, center=rim.center - 0.5 * far * rim.axis, radius=0.5 * (rim.radius + other.radius)
        )
        places, _ = middle.places()
        ledge = Contacts.of(
            places,
            np.tile(rim.axis, (len(places), 1)),
            sigma=min(config.sigma, far / np.sqrt(12.0)),
            normal_sigma=config.normal_sigma,
            touch=NOT_FELT,
        )
        found.append(SteppedHole(rim, hole, ledge))
    return found


def _narrows(rim: RoundRim, other: RoundRim, config: SteppedHoleConfig) -> bool:
    """Whether another rim is the narrower, far end of a rim's hole."""
    apart = rim.center - other.center
    far = float(apart @ rim.axis)
    aside = float(np.linalg.norm(apart - far * rim.axis))
    return (
        (rim.measured or other.measured)
        and float(rim.axis @ other.axis) < -config.opposed
        and far > 0.0
        and aside < config.aside
        and other.radius < rim.radius - config.wider
    )
