"""Triangles as a graph: neighbors, open edges, merged corners and consistent winding."""

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
    forth, back = _directed(triangles)
    _, counts = np.unique(np.minimum(forth, back), return_counts=True)
    return int((counts % 2).sum())


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


def merged(vertices: Floats, triangles: Ints, grid: float) -> tuple[Floats, Ints]:
    """Vertices that share a cell of `grid` [mm] made one (0: equal ones), without triangles that vanish."""
    used, local = np.unique(triangles, return_inverse=True)
    points = vertices[used]
    keys = points + 0.0 if grid == 0 else np.round(points / grid)
    _, first, same = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    corners = same.reshape(-1)[local.reshape(-1, 3)]
    whole = (corners != np.roll(corners, 1, axis=1)).all(axis=1)
    a, b, c = np.moveaxis(points[first][corners], 1, 0)
    if not np.linalg.norm(np.cross(b - a, c - a), axis=1).any():
        whole[:] = False
    return points[first], corners[whole]


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
    forth, back = _directed(triangles)
    _, edge, counts = np.unique(np.minimum(forth, back), return_inverse=True, return_counts=True)
    edge = edge.reshape(-1)
    order = np.argsort(edge, kind="stable")
    pairs = order[np.repeat(counts, counts) == 2].reshape(-1, 2)
    against = np.where(forth[pairs[:, 0]] == forth[pairs[:, 1]], 2, 1)
    n = len(triangles)
    links = coo_array((against, (pairs[:, 0] // 3, pairs[:, 1] // 3)), shape=(n, n)).tocsr()
    links = links.maximum(links.T)
    count, shell = connected_components(links, False)
    flip = np.zeros(n, dtype=bool)
    for first in np.unique(shell, return_index=True)[1][:count]:
        walk, before = breadth_first_order(links, int(first), False)
        for t in walk[1:]:
            flip[t] = flip[before[t]] != (links[before[t], t] == 2)
    return flip
