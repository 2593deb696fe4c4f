"""Where a closed surface passes through itself: an edge of one triangle pierces another that it does not touch.

Rays along the edges find candidates in single precision; each is proved in double precision by the ray and
triangle test of Moller and Trumbore (1997), with margins, so that what merely touches does not count.
"""

import numpy as np

from models.raycast import caster
from primitives.arrays import Floats, Ints

MARGIN = 1e-3  # share of the edge, and of the triangle, by which a crossing must be inside both
DEEP = 1e-4  # share of the longest side by which an edge's ends must lie on both sides of the triangle


def crossings(vertices: Floats, triangles: Ints) -> Floats:
    """(n, 3) points where edges of a closed mesh pierce triangles."""
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    ends = ends[ends[:, 0] < ends[:, 1]]  # of a closed surface, whose edges run both ways, each edge once
    middle = vertices.mean(axis=0)
    local = vertices - middle
    along = local[ends[:, 1]] - local[ends[:, 0]]
    length = np.linalg.norm(along, axis=1)
    rays = caster(local, triangles)
    size = float(np.ptp(vertices, axis=0).max())
    start = local[ends[:, 0]] + MARGIN * along
    direction = along / np.maximum(length, 1e-300)[:, None]
    reached, hit = rays.first_hits(
        np.ascontiguousarray(start, dtype=np.float32), np.ascontiguousarray(direction, dtype=np.float32)
    )
    found = np.flatnonzero((hit >= 0) & (reached < length * (1 - 2 * MARGIN)))
    corners = triangles[hit[found]]
    apart = ~(corners[:, :, None] == ends[found][:, None, :]).any(axis=(1, 2))
    found, corners = found[apart], corners[apart]
    a, b, c = (local[corners[:, k]] for k in range(3))
    o, d = local[ends[found, 0]], along[found]
    u, v = b - a, c - a
    normal = np.cross(u, v)
    area = np.linalg.norm(normal, axis=1)
    slope = np.einsum("ij,ij->i", d, normal)
    safe = np.where(np.abs(slope) > 0, slope, 1.0)
    t = np.einsum("ij,ij->i", a - o, normal) / safe
    offset = o + t[:, None] * d - a
    scale = np.maximum(area, 1e-300) ** 2
    p = np.einsum("ij,ij->i", np.cross(offset, v), normal) / scale
    q = np.einsum("ij,ij->i", np.cross(u, offset), normal) / scale
    depth = np.abs(slope) / np.maximum(area, 1e-300) * np.minimum(t, 1 - t)
    sure = (np.abs(slope) > 0) & (np.minimum(np.minimum(p, q), 1 - p - q) > MARGIN) & (depth > DEEP * size)
    points: Floats = (o + t[:, None] * d)[sure & (t > MARGIN) & (t < 1 - MARGIN)] + middle
    return points
