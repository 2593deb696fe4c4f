"""Gaps that places round them make circles of, and that have corners.

Where touched places lie a few millimeters apart, a hexagon is nearly a circle.  Out of a circle every piece of its
edge leads to the middle; out of a side most pieces do not (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exploration.control.sighting import Sighting
from exploration.planning.open.round_rims import RoundRim


@dataclass(frozen=True)
class CorneredConfig:
    """When edges beside a gap are sides."""

    least: float = 10.0  # [mm] radius: on a smaller circle a pad sees any line
    beside: float = 4.0  # [mm] from the circle, where an edge is the gap's own
    alike: float = 0.95  # least cosine between the normals of the two
    turned: float = 0.2  # [rad] from the way to the middle, from which an edge does not lead there
    few: int = 3  # such edges at least,
    share: float = 0.3  # of all beside it


def cornered(rim: RoundRim, edges: Sequence[Sighting], config: CorneredConfig = CorneredConfig()) -> bool:
    """Whether a gap has straight sides, by the edges that were seen beside it."""
    if rim.radius < config.least:
        return False
    turned = []
    for edge in edges:
        inward = rim.center - edge.point
        inward = inward - (inward @ rim.axis) * rim.axis
        away = float(np.linalg.norm(inward))
        leads = float(edge.outward @ inward) / max(away, 1e-9)
        own = abs(away - rim.radius) < config.beside and float(edge.normal @ rim.axis) > config.alike
        if own and leads > 0.0:  # another leads away from the gap: the outer rim of a lug
            turned.append(leads < np.cos(config.turned))
    return sum(turned) >= config.few and float(np.mean(turned)) > config.share
