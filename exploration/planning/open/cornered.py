"""Gaps that places round them make circles of, and that have corners.

Where touched places lie a few millimeters apart, a hexagon is nearly a circle.  Out of a circle every piece of its
edge leads to the middle; out of a side most pieces do not.  And where pads lay all round it, their picture shows
how far from the middle the face begins: equally far all round a circle, but for a keyway (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exploration.control.sighting import Sighting
from exploration.planning.known.mosaic import Mosaic
from exploration.planning.known.picture_lines import begins, share_at
from exploration.planning.open.round_rims import RoundRim
from primitives.arrays import Floats
from primitives.pose import frame_along


@dataclass(frozen=True)
class CorneredConfig:
    """When edges beside a gap are sides."""

    least: float = 10.0  # [mm] radius: on a smaller circle a pad sees any line
    beside: float = 4.0  # [mm] from the circle, where an edge is the gap's own
    alike: float = 0.95  # least cosine between the normals of the two
    turned: float = 0.2  # [rad] from the way to the middle, from which an edge does not lead there
    few: int = 3  # such edges at least,
    share: float = 0.3  # of all beside it
    about: float = 4.0  # [mm] either way from the circle, where a picture is asked for its edge,
    turns: int = 48  # in so many directions,
    seen: float = 0.7  # and so many of them must have been seen
    off: tuple[float, float] = (0.3, 0.02)  # [mm], and of the radius, that half of them are off at least


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


def pictured_cornered(rim: RoundRim, mosaic: Mosaic, config: CorneredConfig = CorneredConfig()) -> bool:
    """Whether the picture of the face round a gap shows that it is no circle."""
    if rim.bent or rim.radius < config.least:
        return False
    turn = 2.0 * np.pi * np.arange(config.turns) / config.turns
    ways = np.column_stack([np.cos(turn), np.sin(turn)])
    edges = _edges(rim, ways, mosaic, config)
    known = np.isfinite(edges)
    if known.mean() < config.seen:
        return False
    moved = np.column_stack([np.ones(len(turn)), ways])[known]  # a circle with its middle a little aside
    off = edges[known] - moved @ np.linalg.lstsq(moved, edges[known], rcond=None)[0]
    apart = float(np.median(np.abs(off - np.median(off))))
    return apart > max(config.off[0], config.off[1] * rim.radius)


def _edges(rim: RoundRim, ways: Floats, mosaic: Mosaic, config: CorneredConfig) -> Floats:
    """(n,) [mm] from its middle to where the face begins along (n, 2) ways in its plane; NaN where nobody saw."""
    plane, low = frame_along(rim.axis)[:, :2], max(rim.radius - config.about, 0.0)
    out = np.arange(low, rim.radius + config.about, mosaic.config.step)
    places = rim.center + (out[:, None, None] * ways) @ plane.T
    lines = share_at(mosaic, rim.axis, places, plane).T
    return np.array([np.nan if (at := begins(out, line)) is None else at for line in lines])
