"""Closed surfaces of a mesh, and which of them bound one body: a body is an outer shell with its cavities.

A shell inside an even number of others bounds material, inside an odd number a cavity (our derivation, where
shells do not cross).  The winding number of a point is the sum of the solid angles of the triangles over
4 pi (Van Oosterom and Strackee 1983): 1 inside, 0 outside.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from models.boundaries.topology import edge_keys
from primitives.arrays import Bools, Floats, Ints

_PROBES = 8  # points of a shell that must all lie inside another
_WITHIN = 0.75  # of a winding number; on a face it is a half


@dataclass(frozen=True, eq=False)
class Bodies:
    """Triangles of each body, wound so that normals point out of the material."""

    triangles: list[Ints]  # of each body (t, 3)
    rows: list[Ints]  # of each body (t,) where they stood
    turned: bool  # whether a shell faced the wrong way
    doubled: int  # shells that faced out inside material; left out, because the material is there already

    def __bool__(self) -> bool:
        return bool(self.triangles)


def bodies(vertices: Floats, triangles: Ints, most: int) -> Bodies:
    """The bodies of a closed mesh whose triangles agree within each shell; none where it has over `most`."""
    shell = _shells(triangles)
    count = int(shell.max()) + 1
    if count > most:
        return Bodies([], [], False, 0)
    corners = vertices[triangles]
    middle = corners.mean(axis=(0, 1))
    a, b, c = np.moveaxis(corners - middle, 1, 0)
    volume = np.bincount(shell, weights=np.einsum("ij,ij->i", a, np.cross(b, c)) / 6, minlength=count)
    inside = _inside(corners, shell, count)
    depth = inside.sum(axis=1)
    owner = np.arange(count)
    for s in np.flatnonzero(depth % 2 == 1):
        around = np.flatnonzero(inside[s])
        owner[s] = around[np.argmax(depth[around])]
    flip, doubled = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
    for s in np.flatnonzero(depth % 2 == 0):
        flip[s] = volume[s] < 0
    for s in np.flatnonzero(depth % 2 == 1):
        flip[s] = flip[owner[s]]
        doubled[s] = (volume[s] > 0) != flip[s]
    groups = [np.flatnonzero((owner[shell] == s) & ~doubled[shell]) for s in np.flatnonzero(depth % 2 == 0)]
    wound = np.where(flip[shell][:, None], triangles[:, ::-1], triangles)
    return Bodies([wound[rows] for rows in groups], groups, bool(flip.any()), int(doubled.sum()))


def winding(points: Floats, corners: Floats) -> Floats:
    """(n,) winding number of (n, 3) points in a closed surface of (t, 3, 3) corners."""
    out = np.empty(len(points))
    for i, point in enumerate(points):
        a, b, c = np.moveaxis(corners - point, 1, 0)
        la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
        top = np.einsum("ij,ij->i", a, np.cross(b, c))
        dot_ab, dot_bc, dot_ca = (np.einsum("ij,ij->i", x, y) for x, y in ((a, b), (b, c), (c, a)))
        out[i] = np.arctan2(top, la * lb * lc + dot_ab * lc + dot_bc * la + dot_ca * lb).sum() / (2 * np.pi)
    return out


def _shells(triangles: Ints) -> Ints:
    """(t,) shell of each triangle, numbered by first appearance.

    Solids that touch along an edge are shells of their own: the four triangles there hold together only where a
    shell would be open without.
    """
    _, edge, counts = np.unique(edge_keys(triangles), return_inverse=True, return_counts=True)
    edge = edge.reshape(-1, 3)
    plain = counts[edge] == 2
    piece = _linked(edge, plain)
    if not plain.all():
        rows, sides = np.nonzero(~plain)
        held, times = np.unique(np.stack([piece[rows], edge[rows, sides]]), axis=1, return_counts=True)
        piece = _linked(edge, plain | np.isin(piece, held[0, times % 2 == 1])[:, None])
    _, first, same = np.unique(piece, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return rank[same.reshape(-1)]


def _linked(edge: Ints, across: Bools) -> Ints:
    """(t,) connected pieces of triangles with (t, 3) edges, over the (t, 3) sides that hold them together."""
    rows, sides = np.nonzero(across)
    n, ends = len(edge), len(edge) + edge[rows, sides]
    size = n + int(edge.max()) + 1
    links = coo_array((np.ones(len(rows), dtype=bool), (rows, ends)), shape=(size, size))
    return np.asarray(connected_components(links, False)[1][:n], dtype=np.int64)


def _inside(corners: Floats, shell: Ints, count: int) -> Bools:
    """(s, s) whether the first shell lies inside the second, by the winding of a few of its points."""
    inside = np.zeros((count, count), dtype=bool)
    if count == 1:
        return inside
    order = np.argsort(shell, kind="stable")
    pieces = np.split(corners[order], np.flatnonzero(np.diff(shell[order])) + 1)
    low = np.array([piece.min(axis=(0, 1)) for piece in pieces])
    high = np.array([piece.max(axis=(0, 1)) for piece in pieces])
    for s, piece in enumerate(pieces):
        within = (low <= low[s]).all(axis=1) & (high >= high[s]).all(axis=1)
        within[s] = False
        probes = piece[np.linspace(0, len(piece) - 1, _PROBES).astype(int)].mean(axis=1)
        for other in np.flatnonzero(within):
            inside[s, other] = (np.abs(winding(probes, pieces[other])) > _WITHIN).all()
    return inside
