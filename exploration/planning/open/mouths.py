"""Mouths: where a flat face is not there, and goes on across: the entrance of a slot, a pocket or a hole.

From a place of a rim the way out of the face leads to the face again, on the other side.  Midway an array may go
in, facing as the face does, until it meets a floor or its own length ends (our derivation).  What stands round
the floor stops strokes on it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numba
import numpy as np

from exploration.planning.known.surface_map import clusters
from primitives.arrays import Floats


@dataclass(frozen=True)
class MouthConfig:
    """What counts as the other side."""

    least: float = 6.0  # [mm] across
    most: float = 120.0  # [mm] across
    aside: float = 2.5  # [mm] of the way straight across
    cluster: float = 6.0  # [mm] between neighboring ways across one mouth


@dataclass(frozen=True)
class Mouth:
    """Midway across."""

    center: Floats  # (3,) [mm] in the face's plane
    normal: Floats  # (3,) out of the face
    across: Floats  # (3,) unit
    width: float  # [mm] between touched places


def mouths(
    cells: Floats, at: Floats, out: Floats, normal: Floats, config: MouthConfig | None = None
) -> list[Mouth]:
    """Ways across from (n, 3) places `at` a rim, along (n, 3) ways `out`, to (m, 3) `cells` of the same face."""
    config = config or MouthConfig()
    widths = _ahead(cells, at, out, config.aside, config.least)
    return [
        Mouth(place + 0.5 * width * way, normal, way, float(width))
        for place, way, width in zip(at, out, widths, strict=True)
        if width < config.most
    ]


@numba.njit(cache=True, error_model="numpy")
def _ahead(cells: Floats, at: Floats, out: Floats, aside: float, least: float) -> Floats:
    """(n,) [mm] along each way, more than `least`, to the first of the cells that is less than `aside` off it."""
    widths = np.full(len(at), np.inf)
    for k in range(len(at)):
        for n in range(len(cells)):
            x, y, z = cells[n, 0] - at[k, 0], cells[n, 1] - at[k, 1], cells[n, 2] - at[k, 2]
            far = x * out[k, 0] + y * out[k, 1] + z * out[k, 2]
            if least < far < widths[k] and x * x + y * y + z * z - far * far < aside * aside:
                widths[k] = far
    return widths


def lids(found: Sequence[Mouth], spacing: float = 2.0) -> tuple[Floats, Floats]:
    """(n, 3) places [mm] on the ways across, and (n, 3) the way that each looks; nobody knows what is behind."""
    places, facing = [np.empty((0, 3))], [np.empty((0, 3))]
    for mouth in found:
        along = np.arange(spacing - 0.5 * mouth.width, 0.5 * mouth.width, spacing)
        places.append(mouth.center + along[:, None] * mouth.across)
        facing.append(np.broadcast_to(mouth.normal, places[-1].shape))
    rows = np.concatenate([np.concatenate(places), np.concatenate(facing)], axis=1)
    _, first = np.unique(np.round(rows / spacing).astype(int), axis=0, return_index=True)
    return rows[first, :3], rows[first, 3:]


def gathered(found: Sequence[Mouth], config: MouthConfig | None = None) -> list[list[Mouth]]:
    """The ways across each mouth, the one in the middle first; the widest mouth first."""
    config, out = config or MouthConfig(), list[list[Mouth]]()
    if not found:
        return out
    centers = np.array([mouth.center for mouth in found])
    apart = np.column_stack([centers, 10.0 * config.cluster * np.array([mouth.normal for mouth in found])])
    for members in clusters(apart, config.cluster):
        rows = np.flatnonzero(members)
        away = np.linalg.norm(centers[rows] - centers[rows].mean(axis=0), axis=1)
        out.append([found[rows[k]] for k in np.argsort(away, kind="stable")])
    return sorted(out, key=lambda ways: -ways[0].width)
