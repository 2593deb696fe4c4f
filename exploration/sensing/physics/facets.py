"""A mesh as convex planar facets: triangles on one plane, merged where their outline is one convex loop.

A cap of 200 slivers is one facet: drawing it costs its outline and not its triangles.  What is not convex, or has
holes, stays in triangles.  The facets near a pad are listed once and again only when it has moved by the list's
slack, as in molecular dynamics (Verlet 1967).
"""

from dataclasses import dataclass
from math import dist

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from primitives.arrays import Bools, Floats, Ints
from primitives.surface import TriangleSurface

_PARALLEL = (
    1e-7  # difference of unit normals, and [mm] off the plane over the facet's size, that count as none
)
_SLACK = 5.0  # [mm] that the pad may move before facets are listed again


@dataclass(frozen=True)
class Facets:
    """Convex planar polygons, wound so that normals point out; facet f is loop[start[f] : start[f + 1]]."""

    normals: Floats  # (f, 3)
    start: Ints  # (f + 1,)
    loop: Floats  # (sum, 3) [mm]

    def take(self, which: Ints) -> "Facets":
        """Some of them."""
        counts = np.diff(self.start)[which]
        start = np.concatenate([[0], np.cumsum(counts)])
        rows = np.repeat(self.start[:-1][which] - start[:-1], counts) + np.arange(start[-1])
        return Facets(np.ascontiguousarray(self.normals[which]), start, np.ascontiguousarray(self.loop[rows]))


def facets_of(surface: TriangleSurface) -> Facets:
    """Every triangle of positive area, merged with its neighbors where that leaves a convex outline."""
    vertices, triangles, neighbors = surface.vertices, surface.triangles, surface.neighbors
    corners = vertices[triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double_area = np.linalg.norm(cross, axis=1)
    apart = double_area > 1e-12
    normals = cross / np.where(apart, double_area, 1.0)[:, None]
    across = np.where(neighbors >= 0, neighbors, np.arange(len(triangles))[:, None])
    group = _coplanar(normals, across, apart)
    size, order = np.bincount(group), np.argsort(group, kind="stable")
    begin = np.cumsum(size) - size
    pairs = order[begin[size == 2, None] + [0, 1]]
    quads = _quads(vertices, triangles, across, pairs)
    whole = _convex(quads, normals[pairs[:, 0]])
    apart[pairs[whole].ravel()] = False
    first, loops = list[int](), list[Floats]()
    for k in np.flatnonzero(size > 2):
        members = order[begin[k] : begin[k] + size[k]]
        loop = _outline(vertices, triangles, across, group, members, normals)
        if loop is not None:
            apart[members] = False
            first.append(members[0])
            loops.append(loop)
    of = np.concatenate([np.flatnonzero(apart), pairs[whole, 0], np.array(first, dtype=np.int64)])
    counts = [3] * int(apart.sum()) + [4] * int(whole.sum()) + [len(loop) for loop in loops]
    start = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    rows = np.concatenate([corners[apart].reshape(-1, 3), quads[whole].reshape(-1, 3), *loops])
    return Facets(normals[of], start, rows).take(np.argsort(group[of], kind="stable"))


def _coplanar(normals: Floats, across: Ints, solid: Bools) -> Ints:
    """(t,) group of each triangle: neighbors `across` (t, 3) its sides share it where their normals are one."""
    alike = (
        (np.abs(normals[across] - normals[:, None]).max(axis=2) < _PARALLEL) & solid[across] & solid[:, None]
    )
    row, corner = np.nonzero(alike)
    links = coo_array((np.ones(len(row)), (row, across[row, corner])), shape=(len(normals),) * 2)
    return np.asarray(connected_components(links, directed=False)[1], dtype=np.int64)


def _quads(vertices: Floats, triangles: Ints, across: Ints, pairs: Ints) -> Floats:
    """(k, 4, 3) corners of (k, 2) pairs of triangles that share an edge: most of a surface of revolution."""
    one, other = pairs.T
    edge, back = (
        np.argmax(across[own] == beside[:, None], axis=1) for own, beside in ((one, other), (other, one))
    )
    loop = np.stack(
        [triangles[one, (edge + k) % 3] for k in (1, 2, 0)] + [triangles[other, (back + 2) % 3]], axis=1
    )
    return np.asarray(vertices[loop])


def _outline(
    vertices: Floats, triangles: Ints, across: Ints, group: Ints, members: Ints, normals: Floats
) -> Floats | None:
    """The one convex loop (n, 3) round coplanar triangles; None where there is no such loop."""
    rim = (group[across[members]] != group[members[0]]) | (across[members] == members[:, None])
    t, i = np.nonzero(rim)
    follows = dict(
        zip(triangles[members[t], i].tolist(), triangles[members[t], (i + 1) % 3].tolist(), strict=True)
    )
    if len(follows) != len(t) or len(t) < 3:
        return None
    first = int(triangles[members[t[0]], i[0]])
    names = [first]
    while (following := follows.get(names[-1])) != first:
        if following is None or len(names) == len(t):
            return None
        names.append(following)
    if len(names) != len(t):
        return None
    loop = np.asarray(vertices[names])
    return loop if _convex(loop[None], normals[members[:1]])[0] else None


def _convex(loops: Floats, normals: Floats) -> Bools:
    """(k,) which of (k, n, 3) loops are flat across their (k, 3) normals, and turn one way only."""
    sides = np.roll(loops, -1, axis=1) - loops
    after = np.roll(sides, -1, axis=1)
    size = np.ptp(loops, axis=1).max(axis=1)
    turns = np.einsum("kni,ki->kn", np.cross(sides, after), normals)
    off = np.abs(np.einsum("kni,ki->kn", loops - loops[:, :1], normals)).max(axis=1)
    return np.asarray((off <= 10 * _PARALLEL * size) & (turns.min(axis=1) >= -_PARALLEL * size * size))


class NearFacets:
    """The facets that a ball of given radius [mm] may meet."""

    slack = _SLACK

    def __init__(self, facets: Facets, radius: float) -> None:
        self.all, self._radius = facets, radius + _SLACK
        lengths = np.diff(facets.start)
        self._low = np.minimum.reduceat(facets.loop, facets.start[:-1]) if len(lengths) else np.zeros((0, 3))
        self._high = np.maximum.reduceat(facets.loop, facets.start[:-1]) if len(lengths) else np.zeros((0, 3))
        self._center: tuple[float, float, float] | None = None
        self.facets = facets.take(np.zeros(0, np.int64))

    def around(self, x: float, y: float, z: float) -> float:
        """Bring the list up to date; how far the ball may move [mm] before it must be asked again."""
        if self._center is not None:
            left = _SLACK - dist((x, y, z), self._center)
            if left >= 0.0:
                return left
        self._center = (float(x), float(y), float(z))
        center = np.array(self._center)
        away = np.maximum(0.0, np.maximum(self._low - center, center - self._high))
        self.facets = self.all.take(np.flatnonzero(np.einsum("ij,ij->i", away, away) <= self._radius**2))
        return _SLACK
