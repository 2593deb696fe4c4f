"""Pieces of a freeform face that a cylinder or cone fits by chance, given back to it.

Any smooth surface is nearly a cylinder where it is small, so such pieces end where they are off by the tolerance.
A piece is told by that, and by its rim: it runs on smoothly into what nothing explains and into other such pieces,
where a face of its own ends at an edge, at a plane or at another exact surface; and it is small beside all that
hangs together there (our derivation).
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from models.recovery.curved import Region, alike
from models.recovery.fits import corners_of
from models.recovery.grow import Mesh
from models.recovery.leftover import LeftoverOptions, freeform_groups
from primitives.arrays import Bools

_OPEN = 0.6  # [1] of a piece's rim that runs on into what is freeform
_SMALL = 0.1  # [1] of the area that hangs together with a piece
_OFF = 0.3  # [1] of the corners' noise, that half of a piece's are off; single precision leaves a tenth
_FEW = 3  # corners for each number that a shape has, fewer than which fit too easily


def without_fragments(
    mesh: Mesh, regions: list[Region], noise: float, options: LeftoverOptions
) -> list[Region]:
    """The regions that are no such pieces."""
    creases, n = mesh.creases, len(mesh.flats)
    first = np.repeat(np.arange(n), np.diff(creases.start))
    smooth = (np.abs(creases.turn) < options.smooth) & ~mesh.thin[creases.other]
    label = np.full(n, -1, dtype=np.int64)
    for i, region in enumerate(regions):
        label[region.facets] = i
    rows = (label[first] >= 0) & (label[first] != label[creases.other])
    mine, other, length = label[first[rows]], creases.other[rows], creases.length[rows]
    rim = np.bincount(mine, length, len(regions))
    loose = np.zeros(n, dtype=bool)
    for group in freeform_groups(mesh, label, options):
        loose[group] = True
    gone = _suspect(mesh, regions, noise, options)
    while gone.any():
        open_ = smooth[rows] & (loose[other] | (gone[label[other]] & (label[other] >= 0)))
        left = gone & (np.bincount(mine, length * open_, len(regions)) > _OPEN * rim)
        if np.array_equal(left, gone):
            break
        gone = left
    return [region for region, drop in zip(regions, gone, strict=True) if not drop]


def _suspect(mesh: Mesh, regions: list[Region], noise: float, options: LeftoverOptions) -> Bools:
    """(r,) regions small beside what hangs together smoothly with them, which fit not quite or too easily."""
    first, second = alike(mesh, options.alike, options.smooth)
    n, area = len(mesh.flats), mesh.flats.area
    links = coo_array((np.ones(len(first), dtype=bool), (first, second)), shape=(n, n))
    piece = np.asarray(connected_components(links, False)[1], dtype=np.int64)
    total = np.bincount(piece, area)
    out = np.zeros(len(regions), dtype=bool)
    for i, region in enumerate(regions):
        around = total[piece[region.facets[np.argmax(area[region.facets])]]]
        if float(area[region.facets].sum()) < _SMALL * around:
            corners = mesh.vertices[corners_of(mesh, region.facets)]
            off = float(np.median(np.abs(region.shape.signed_distance(corners))))
            out[i] = off > _OFF * noise or len(corners) < _FEW * region.shape.dof
    return out
