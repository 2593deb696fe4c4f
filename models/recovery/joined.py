"""Fragments of one surface made one, and the facets that cuts left beside it taken in.

Where a boolean cut the chords of a mesh, new corners lie on chords and not on the surface: up to a chord's sag
away.  Only what no surface claimed at the strict tolerance is taken at this one, or fragments as a whole.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from models.recovery.curved import Region
from models.recovery.fits import depth
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
    out: list[Region] = []
    for i, region in enumerate(ordered):
        mine: Ints = np.flatnonzero(owner == i)
        if not len(mine):
            continue
        sag = float(np.quantile(depth(mesh, region.shape, mine), 0.9))
        reach = replace(region.reach, corner=3 * noise + 1.3 * sag, middle=3 * noise + 2.5 * sag)
        free = (owner == -1) | (owner > i)
        grown = grow(mesh, region.shape, region.convex, mine, free, reach)
        takes = owner[grown]
        for j in np.unique(takes[takes > i]):
            share = area[grown[takes == j]].sum() / area[owner == j].sum()
            if share > _COVERED:
                owner[owner == j] = i
        owner[grown[takes == -1]] = i
        out.append(replace(region, facets=np.flatnonzero(owner == i), reach=reach))
    return out
