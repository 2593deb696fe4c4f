"""Closes meshes whose triangles meet side to part of a side: corners that lie on an open edge cut it."""

import numpy as np

from primitives.arrays import Floats, Ints

_MOST_PAIRS = 20_000_000  # open edges times open corners that are looked through
_ROUNDS = 8  # a triangle is cut at one side in each


def stitched(vertices: Floats, triangles: Ints, tolerance: float) -> tuple[Ints, Ints]:
    """Triangles (t', 3), those with an open edge cut where a corner lies within `tolerance` [mm] of it.

    Beside them the (t',) triangle that each is or was cut from.
    """
    source = np.arange(len(triangles))
    for _ in range(_ROUNDS):
        cut = _cut(vertices, triangles, tolerance)
        if cut is None:
            break
        triangles, before = cut
        source = source[before]
    return triangles, source


def _cut(vertices: Floats, triangles: Ints, tolerance: float) -> tuple[Ints, Ints] | None:
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    _, edge, counts = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True, return_counts=True)
    loose = np.flatnonzero(counts[edge.reshape(-1)] == 1)
    corners = np.unique(ends[loose])
    if not len(loose) or len(loose) * len(corners) > _MOST_PAIRS:
        return None
    start, along = vertices[ends[loose, 0]], vertices[ends[loose, 1]] - vertices[ends[loose, 0]]
    length = np.linalg.norm(along, axis=1)
    done: set[int] = set()
    pieces: list[tuple[int, int, int]] = []
    origins: list[int] = []
    for i in np.flatnonzero(length > 2 * tolerance).tolist():
        triangle, side = divmod(int(loose[i]), 3)
        offset = vertices[corners] - start[i]
        share = offset @ along[i] / length[i] ** 2
        away = np.linalg.norm(offset - share[:, None] * along[i], axis=1)
        margin = tolerance / length[i]
        on = np.flatnonzero((away < tolerance) & (share > margin) & (share < 1 - margin))
        if not len(on) or triangle in done:
            continue
        a, b, c = np.roll(triangles[triangle], -side).tolist()
        run = [a, *corners[on[np.argsort(share[on])]].tolist(), b]
        pieces += [(run[k], run[k + 1], c) for k in range(len(run) - 1)]
        origins += [triangle] * (len(run) - 1)
        done.add(triangle)
    if not done:
        return None
    kept = np.delete(np.arange(len(triangles)), sorted(done))
    cut = np.concatenate([triangles[kept], np.array(pieces, dtype=np.int64)])
    return cut, np.concatenate([kept, np.array(origins, dtype=np.int64)])
