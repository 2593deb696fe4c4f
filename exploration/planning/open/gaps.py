"""Gaps in a flat face: places where it is not there, with the face felt all round them.

A lot of free places that hang together has a deepest one, farthest from all that was touched.  Seen from there,
the nearest touched place of every direction is on the gap's rim; a gap is shut where nearly all directions have
one.  A circle through those places (`round_rims`) is where a round hole may be: how round it is, a look at its
rim tells (`sensing.lines.round_hole`).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import KDTree

from exploration.planning.known.surface_map import clusters
from exploration.planning.open.round_rims import RoundRim, RoundRimConfig, round_rim
from primitives.arrays import Floats
from primitives.pose import frame_along


@dataclass(frozen=True)
class GapsConfig:
    """When free places are a gap."""

    cell: float = 1.0  # [mm] free places nearer than this are one
    together: float = 3.0  # [mm] between neighbors of one gap
    least: int = 2  # such places
    ways: int = 16  # directions in which its rim is looked for
    clear: float = 1.2  # [mm] of a free place from all that was touched
    places: int = 8  # of its rim that were touched
    strays: int = 3  # of them, the farthest, that may be past it
    rim: RoundRimConfig = field(default_factory=lambda: RoundRimConfig(rms=1.2, share=0.25, around=4.6))
    trimmed: RoundRimConfig = field(  # without strays: past a wide gap, as between tines, most ways lead out
        default_factory=lambda: RoundRimConfig(rms=0.9, share=0.25, largest=8.0)
    )


def gaps(
    cells: Floats, free: Floats, axis: Floats, face: int, config: GapsConfig = GapsConfig()
) -> list[RoundRim]:
    """Circles about the gaps in a face of outward (3,) `axis`, touched at (n, 3) cells, free at (m, 3) places."""
    if len(cells) < config.places or not len(free):
        return []
    turn = frame_along(axis)
    felt = cells @ turn
    places = (free @ turn)[:, :2]
    _, first = np.unique(np.round(places / config.cell).astype(int), axis=0, return_index=True)
    places = places[np.sort(first)]
    away = np.asarray(KDTree(felt[:, :2]).query(places)[0])
    places, away = places[away > config.clear], away[away > config.clear]
    found: list[RoundRim] = []
    for members in clusters(places, config.together):
        if members.sum() < config.least:
            continue
        rows = np.flatnonzero(members)
        rim, out = _rim_about(places[rows[np.argmax(away[rows])]], felt, config)
        for kept, told in ((slice(None), config.rim), (slice(-config.strays), config.trimmed)):
            circle = round_rim(rim[kept] @ turn.T, out[kept] @ turn.T, axis, face, told)
            if circle is not None:
                found.append(circle)
                break
    return found


def _rim_about(middle: Floats, felt: Floats, config: GapsConfig) -> tuple[Floats, Floats]:
    """(n, 3) the touched places nearest to a (2,) middle, one a direction, and (n, 3) the ways to it.

    The nearest of them first.
    """
    toward = felt[:, :2] - middle
    far = np.linalg.norm(toward, axis=1)
    way = np.floor(np.arctan2(toward[:, 1], toward[:, 0]) / (2.0 * np.pi) * config.ways).astype(int)
    order = np.argsort(far, kind="stable")
    _, first = np.unique(way[order], return_index=True)
    rows = order[np.sort(first)]
    out = np.column_stack([-toward[rows] / np.maximum(far[rows], 1e-9)[:, None], np.zeros(len(rows))])
    return felt[rows], out
