"""Flat faces that were cut into triangles folded over one another, cut anew.

Many programs cut a polygon into a fan from its first corner.  Where it is not convex the fan leaves it, and comes
back over itself: the volume is right and the surface is not.  Two triangles that lie on one another along a common
edge tell such a face; its outline stands, and is filled again.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from models.boundaries.topology import edge_keys, open_edges, triangle_neighbors
from models.formats.holes import filled
from primitives.arrays import Bools, Floats, Ints

_FLAT = 1e-6  # of the mesh's longest side, that corners of one plane may be off
_THICK = 1e-3  # of its longest side, below which a triangle's normal is noise


def folded(vertices: Floats, triangles: Ints) -> Bools:
    """(t,) triangles of flat faces that are folded over themselves."""
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    cross = np.cross(b - a, c - a)
    twice = np.linalg.norm(cross, axis=1)
    longest = np.max([np.einsum("ij,ij->i", p - q, p - q) for p, q in ((a, b), (b, c), (c, a))], axis=0)
    normal = cross / np.maximum(twice, 1e-300)[:, None]
    neighbors = triangle_neighbors(triangles)
    rows, sides = np.nonzero(neighbors >= 0)
    others = neighbors[rows, sides]
    larger = twice[rows] >= twice[others]
    rows, others = rows[larger], others[larger]
    against = np.einsum("ij,ij->i", normal[rows], normal[others])
    close = np.abs(against) > 0.999
    rows, others, against = rows[close], others[close], against[close]
    off = np.einsum("ikj,ij->ik", vertices[triangles[others]] - a[rows][:, None], normal[rows])
    flat = np.abs(off).max(axis=1) < _FLAT * float(np.ptp(vertices, axis=0).max())
    rows, others, against = rows[flat], others[flat], against[flat]
    thick = twice > _THICK * longest
    over = (against < 0) & thick[rows] & thick[others]
    if not over.any():
        return np.zeros(len(triangles), dtype=bool)
    links = coo_array((np.ones(len(rows), dtype=bool), (rows, others)), shape=2 * (len(triangles),))
    piece = connected_components(links, False)[1]
    return np.asarray(np.isin(piece, piece[rows[over]]))


def unfolded(vertices: Floats, triangles: Ints) -> tuple[Ints, Ints, int]:
    """The triangles with folded faces cut anew, the row that each was (-1: new), and how many faces were."""
    rows, bad = np.arange(len(triangles)), folded(vertices, triangles)
    if not bad.any() or bad.all():
        return triangles, rows, 0
    rest = triangles[~bad]
    if not open_edges(rest):
        return rest, rows[~bad], 1  # a sheet without thickness, closed in itself
    patch, faces = filled(vertices, rest)
    mended = np.concatenate([rest, patch])
    if not len(patch) or open_edges(mended) or _crowded(mended) > _crowded(triangles):
        return triangles, rows, 0
    return mended, np.concatenate([rows[~bad], np.full(len(patch), -1)]), faces


def _crowded(triangles: Ints) -> int:
    """How many edges more than two triangles share."""
    return int((np.unique(edge_keys(triangles), return_counts=True)[1] > 2).sum())
