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

from primitives.arrays import Floats, Ints
from primitives.surface import TriangleSurface

_PARALLEL = (
    1e-7  # difference of unit normals, and [mm] off the plane over the facet's size, that count as none
)
_NEXT, _LAST = [1, 2, 0], [2, 0, 1]
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
    solid = double_area > 1e-12
    normals = cross / np.where(solid, double_area, 1.0)[:, None]
    across = np.where(neighbors >= 0, neighbors, np.arange(len(triangles))[:, None])
    alike = (
        (np.abs(normals[across] - normals[:, None]).max(axis=2) < _PARALLEL) & solid[across] & solid[:, None]
    )
    row, corner = np.nonzero(alike)
    links = coo_array((np.ones(len(row)), (row, across[row, corner])), shape=(len(triangles),) * 2)
    group = np.asarray(connected_components(links, directed=False)[1], dtype=np.int64)
    outlines, outline_normals = [], []
    order = np.argsort(group, kind="stable")
    for members in np.split(order, np.flatnonzero(np.diff(group[order])) + 1):
        if not solid[members[0]]:
            continue
        merged = _outline(vertices, triangles, across, group, members, normals) if len(members) > 1 else None
        outlines += [merged] if merged is not None else list(corners[members])
        outline_normals += [normals[members[0]]] if merged is not None else list(normals[members])
    start = np.concatenate([[0], np.cumsum([len(o) for o in outlines])]).astype(np.int64)
    return Facets(
        np.array(outline_normals).reshape(-1, 3), start, np.concatenate([np.zeros((0, 3)), *outlines])
    )


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
    loop = vertices[names]
    ahead = np.concatenate([loop[1:], loop[:1]])
    sides = ahead - loop
    after = np.concatenate([sides[1:], sides[:1]])
    size = float((loop.max(axis=0) - loop.min(axis=0)).max())
    normal = normals[members[0]]
    turns = (
        sides[:, _NEXT] * after[:, _LAST] - sides[:, _LAST] * after[:, _NEXT]
    ) @ normal  # their cross products
    flat = np.abs((loop - loop[0]) @ normal).max() <= 10 * _PARALLEL * size
    return loop if flat and turns.min() >= -_PARALLEL * size * size else None


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
