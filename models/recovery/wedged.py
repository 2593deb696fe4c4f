"""Triangles and fragments that a surface left out only because its triangulation is uneven there.

Where a fine rim meets a coarse one a mesher puts long triangles in, whose normals are farther from the surface's
than those of the patch that the surface was found from.  A triangle with all corners on the surface, which its
facets hold along a side, is one of them: a flat of its own has more corners (our derivation).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from models.recovery.curved import Region
from models.recovery.curved_options import CurvedOptions
from models.recovery.fits import corners_of
from models.recovery.grow import Mesh
from primitives.arrays import Floats, Ints

_HELD = 0.3  # [1] of a fragment's rim that must lie against the surface's own facets
_FRAGMENT = 12  # facets of a region that may be a piece of another


def with_wedged(mesh: Mesh, regions: list[Region], noise: float, options: CurvedOptions) -> list[Region]:
    """The regions, each with the triangles and the fragments that are wedged into it."""
    owner = np.full(len(mesh.flats), -1, dtype=np.int64)
    for i, region in enumerate(regions):
        owner[region.facets] = i
    for i in sorted(range(len(regions)), key=lambda i: len(regions[i].facets)):
        facets = np.flatnonzero(owner == i)
        if 0 < len(facets) <= _FRAGMENT:
            owner[facets] = _holder(mesh, regions, owner, facets, noise, options, i)
    triangles = np.diff(mesh.flats.start) == 3
    while True:
        waiting = np.flatnonzero((owner < 0) & triangles & ~mesh.thin & _beside(mesh, owner))
        found = [
            _holder(mesh, regions, owner, waiting[k : k + 1], noise, options, -1) for k in range(len(waiting))
        ]
        if max(found, default=-1) < 0:
            break
        owner[waiting] = found
    kept = [replace(region, facets=np.flatnonzero(owner == i)) for i, region in enumerate(regions)]
    return [region for region in kept if len(region.facets)]


def _beside(mesh: Mesh, owner: Ints) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """(f,) whether some neighbor is owned."""
    first = np.repeat(np.arange(len(owner)), np.diff(mesh.creases.start))
    return np.bincount(first, owner[mesh.creases.other] >= 0, len(owner)) > 0


def _holder(
    mesh: Mesh,
    regions: list[Region],
    owner: Ints,
    facets: Ints,
    noise: float,
    options: CurvedOptions,
    own: int,
) -> int:
    """The region that holds some facets of one owner; that owner where none does."""
    creases = mesh.creases
    rows = np.concatenate([np.arange(creases.start[f], creases.start[f + 1]) for f in facets])
    rows = rows[~np.isin(creases.other[rows], facets)]
    beside, length = owner[creases.other[rows]], creases.length[rows]
    smooth = (np.abs(creases.turn[rows]) < options.smooth) & (beside >= 0) & (beside != own)
    if not smooth.any():
        return own
    held = np.bincount(beside[smooth], length[smooth])
    corners: Floats = mesh.vertices[corners_of(mesh, facets)]
    least = 0.0 if own < 0 else _HELD * float(length.sum())
    for best in np.argsort(-held)[: np.count_nonzero(held > least)].tolist():
        larger = len(regions[best].facets) > len(facets)
        if larger and np.abs(regions[best].shape.signed_distance(corners)).max() < 3 * noise:
            return int(best)
    return own
