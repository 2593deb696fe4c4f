"""Triangles as a graph: neighbors, open edges and consistent winding."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from primitives.arrays import Bools, Floats, Ints


def triangle_neighbors(triangles: Ints) -> Ints:
    """(t, 3) triangle across the edge from corner i to corner i + 1; -1 where there is none."""
    forth, back = _directed(triangles)
    order = np.argsort(forth)
    place = np.minimum(np.searchsorted(forth[order], back), len(order) - 1)
    twin = order[place]
    neighbors: Ints = np.where(forth[twin] == back, twin // 3, -1).reshape(-1, 3)
    return neighbors


def open_edges(triangles: Ints) -> int:
    """How many edges do not pair up, whichever way their triangles are wound; 0 for a closed mesh."""
    _, counts = np.unique(edge_keys(triangles), return_counts=True)
    return int((counts % 2).sum())


def edge_keys(triangles: Ints) -> Ints:
    """(3 t,) one number for each edge, the same for all triangles that have it; three a triangle."""
    forth, back = _directed(triangles)
    return np.minimum(forth, back)


def handles(triangles: Ints, loops: int) -> int:
    """Of one connected piece of a surface with `loops` rims: 1 for a whole torus.

    Euler's count of the piece is 2 - 2 handles - loops, each fan of triangles round a vertex counted as a corner.
    """
    neighbors = triangle_neighbors(triangles)
    rows, sides = np.nonzero(neighbors >= 0)
    others, inner = neighbors[rows, sides], len(rows) // 2
    links = []
    for end in (0, 1):
        corner = (sides + end) % 3
        across = np.argmax(triangles[others] == triangles[rows, corner][:, None], axis=1)
        links.append((3 * rows + corner, 3 * others + across))
    a, b = np.concatenate(links, axis=1)
    n = triangles.size
    corners = int(
        connected_components(coo_array((np.ones(len(a), dtype=bool), (a, b)), shape=(n, n)), False)[0]
    )
    euler = corners - (n - inner) + len(triangles)
    return (2 - loops - euler) // 2


def wound(vertices: Floats, triangles: Ints) -> tuple[Ints, bool]:
    """The triangles wound so that neighbors agree and the volume is positive, and whether any was turned."""
    flip = np.zeros(len(triangles), dtype=bool)
    forth, back = _directed(triangles)
    if not np.array_equal(np.sort(forth), np.sort(back)):
        flip = _disagreeing(triangles)
    turned = np.where(flip[:, None], triangles[:, ::-1], triangles)
    a, b, c = np.moveaxis(vertices[turned] - vertices.mean(axis=0), 1, 0)
    if float(np.einsum("ij,ij->", a, np.cross(b, c))) < 0:
        turned, flip = turned[:, ::-1], ~flip
    return np.ascontiguousarray(turned), bool(flip.any())


def _directed(triangles: Ints) -> tuple[Ints, Ints]:
    """(3 t,) one number for each edge in the direction of its triangle, and for the opposite direction."""
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    top = int(triangles.max(initial=0)) + 1
    return ends[:, 0] * top + ends[:, 1], ends[:, 1] * top + ends[:, 0]


def _disagreeing(triangles: Ints) -> Bools:
    """(t,) triangles wound against the first of their shell, walking over edges that two triangles share."""
    forth, _ = _directed(triangles)
    _, edge, counts = np.unique(edge_keys(triangles), return_inverse=True, return_counts=True)
    edge = edge.reshape(-1)
    order = np.argsort(edge, kind="stable")
    pairs = order[np.repeat(counts, counts) == 2].reshape(-1, 2)
    against = np.where(forth[pairs[:, 0]] == forth[pairs[:, 1]], 2, 1)
    n = len(triangles)
    low, high = np.sort(pairs // 3, axis=1).T
    once = np.unique(low * n + high, return_index=True)[1]  # of triangles that share two edges, one
    low, high, against = low[once], high[once], against[once]
    _, shell = connected_components(coo_array((against, (low, high)), shape=(n, n)), False)
    firsts = np.unique(shell, return_index=True)[1]
    ends = np.append(low, firsts), np.append(high, np.full(len(firsts), n))
    rooted = coo_array(
        (np.append(against, np.ones(len(firsts), dtype=int)), ends), shape=(n + 1, n + 1)
    ).tocsr()
    rooted = rooted.maximum(rooted.T)
    walk, before = breadth_first_order(rooted, n, False)  # one walk over all shells, from a root beside them
    here, there = walk[1:], before[walk[1:]]
    change = np.asarray(rooted[there, here]).ravel() == 2
    flip = np.zeros(n + 1, dtype=bool)
    for t, back, turned in zip(here.tolist(), there.tolist(), change.tolist(), strict=True):
        flip[t] = flip[back] != turned
    return flip[:n]


def count_shells(neighbors: Ints) -> int:
    """Closed surfaces that hang together by (t, 3) neighbors."""
    n = len(neighbors)
    links = coo_array(
        (np.ones(3 * n, dtype=bool), (np.repeat(np.arange(n), 3), neighbors.ravel())), shape=(n, n)
    )
    return int(connected_components(links, False)[0])


def genus(triangles: Ints, shells: int) -> int:
    """Handles over all shells of closed (t, 3) triangles."""
    euler = len(np.unique(triangles)) - 3 * len(triangles) // 2 + len(triangles)
    return shells - euler // 2
