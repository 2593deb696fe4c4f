"""Fragments of one surface made one, and the facets that cuts left beside it taken in.

Where a boolean cut the chords of a mesh, new corners lie on chords and not on the surface: up to a chord's sag
away.  Only what no surface claimed at the strict tolerance is taken at this one, by the surface that it is nearest
to, or fragments as a whole.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from models.recovery.curved import Region
from models.recovery.fits import cut_reach, farthest
from models.recovery.grow import Mesh, grow
from primitives.arrays import Ints

_COVERED = 0.95  # share of a fragment's area that makes it part of another surface


def joined(mesh: Mesh, regions: list[Region], noise: float) -> list[Region]:
    """The regions, largest first, each with what it could take in."""
    area = mesh.flats.area
    owner = np.full(len(mesh.flats), -1, dtype=np.int64)
    ordered = sorted(regions, key=lambda region: -float(area[region.facets].sum()))
    for i, region in enumerate(ordered):
        owner[region.facets] = i
    free = owner == -1
    off = np.full(
        len(owner), np.inf
    )  # [mm] of a facet that was free, from the nearest surface that reaches it
    reaches = [region.reach for region in ordered]
    for i, region in enumerate(ordered):
        mine: Ints = np.flatnonzero((owner == i) & ~free)
        if not len(mine):
            continue
        reach = cut_reach(mesh, region.shape, mine, region.reach, noise)
        grown = grow(mesh, region.shape, region.convex, mine, free | (owner > i), reach)
        takes = np.where(free[grown], -1, owner[grown])
        for j in np.unique(takes[takes > i]):
            share = area[grown[takes == j]].sum() / area[(owner == j) & ~free].sum()
            if share > _COVERED:
                owner[(owner == j) & ~free] = i
        taken = grown[takes == -1]
        away = farthest(mesh, region.shape, taken)
        nearer = away < off[taken]
        owner[taken[nearer]], off[taken[nearer]], reaches[i] = i, away[nearer], reach
    kept = [
        replace(region, facets=np.flatnonzero(owner == i), reach=reaches[i])
        for i, region in enumerate(ordered)
    ]
    return [region for region in kept if len(region.facets)]
