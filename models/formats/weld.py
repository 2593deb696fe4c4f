"""Corners that lie in one place made one vertex, which is what connects a file's triangles to a surface."""

import numpy as np

from primitives.arrays import Floats, Ints

_PRIMES = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)


def welded(vertices: Floats, triangles: Ints, grid: float) -> tuple[Floats, Ints, Ints]:
    """Vertices that share a cell of `grid` [mm] made one (0: equal ones), without triangles that vanish.

    Returns (v', 3) vertices, (t', 3) triangles and the (t',) triangle that each was.
    """
    used, local = renumbered(triangles)
    points = vertices[used]
    first, same = equal_rows(points + 0.0 if grid == 0 else np.round(points / grid) + 0.0)
    corners = same[local]
    whole = np.flatnonzero((corners != np.roll(corners, 1, axis=1)).all(axis=1))
    return points[first], corners[whole], whole


def renumbered(triangles: Ints) -> tuple[Ints, Ints]:
    """The vertices that (t, 3) triangles use, in order, and the triangles counting only those."""
    used = np.zeros(int(triangles.max(initial=-1)) + 1, dtype=bool)
    used[triangles] = True
    place = np.cumsum(used) - 1
    return np.flatnonzero(used), place[triangles]


def equal_rows(keys: Floats | Ints) -> tuple[Ints, Ints]:
    """First row of each group of equal rows, and the (n,) group of each row: by a hash, checked."""
    words = np.ascontiguousarray(keys).view(np.uint64)
    mixed = words * _PRIMES
    mixed ^= mixed >> np.uint64(29)
    _, first, same = np.unique(
        (mixed * _PRIMES[::-1]).sum(axis=1, dtype=np.uint64), return_index=True, return_inverse=True
    )
    if np.array_equal(keys[first][same], keys):
        return first, same.reshape(-1)
    _, first, same = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return first, same.reshape(-1)
