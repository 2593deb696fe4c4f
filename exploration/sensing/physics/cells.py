"""One pass over the skin's cells after the rays at their corners: judge each, then integrate it.

Cells that the corners explain are integrated from them (`corner_hits`), the others exactly (`coverage`), seeded by
the triangles that their corners met; then the empty cells along whose sides a neighbor's indentation runs.
"""

import numpy as np
from numba import njit

from exploration.sensing.physics.corner_hits import (
    COPLANAR,
    COVER,
    EMPTY,
    SIMPLE,
    judge,
    read_corners,
    simple_cell,
)
from exploration.sensing.physics.coverage import FULL, cover_cell
from exploration.sensing.physics.slipped_rays import HIT, MISS
from primitives.arrays import Bools, Floats, Ints

OVERLAP, POKED = 3, 4  # further states of a cell, after those of `corner_hits`


@njit(cache=True, error_model="numpy")
def integrate(
    hits: Ints,
    poses: Floats,
    x_edges: Floats,
    y_edges: Floats,
    start: float,
    vertices: Floats,
    triangles: Ints,
    neighbors: Ints,
    stamps: Ints,
    queue: Ints,
    a: Floats,
    b: Floats,
    corners: Floats,
    kinds: Ints,
    states: Ints,
    modes: Floats,
    partial: Bools,
) -> tuple[float, int]:
    """Judge all cells, then integrate the simple, the crossed and the poked; greatest depth, cells given up."""
    deepest = read_corners(hits, poses, x_edges, y_edges, vertices, triangles, start, corners, kinds)
    modes[:] = 0.0
    partial[:] = False
    rows, columns = states.shape
    found = np.zeros(len(modes))
    crossed = poked = overlaps = 0
    for r in range(rows):
        hy = y_edges[r + 1] - y_edges[r]
        for c in range(columns):
            states[r, c] = EMPTY
            if kinds[r, c] | kinds[r, c + 1] | kinds[r + 1, c] | kinds[r + 1, c + 1] == MISS:
                continue
            hx = x_edges[c + 1] - x_edges[c]
            if _one_plane(corners, kinds, r, c, hx, hy):
                tilt_x, tilt_y = -0.5 * hx * corners[1, r, c], -0.5 * hy * corners[2, r, c]
                depth = tilt_x + tilt_y - corners[0, r, c]
                if depth >= abs(tilt_x) + abs(tilt_y):
                    modes[0, r, c], modes[1, r, c], modes[2, r, c] = depth, tilt_x, tilt_y
                    states[r, c] = SIMPLE
                    continue
                if depth <= -abs(tilt_x) - abs(tilt_y):
                    continue
            states[r, c] = judge(r, c, corners, kinds, hits, hx, hy, vertices, triangles)
            if states[r, c] == SIMPLE:
                simple_cell(r, c, corners, hx, hy, a, b, found)
                partial[r, c] = found[0] > 0.0
                for m in range(len(found)):
                    modes[m, r, c] = found[m]
            elif states[r, c] == COVER:
                crossed += 1
    for wanted in (COVER, POKED):
        if (wanted == COVER and crossed == 0) or (wanted == POKED and poked == 0):
            break
        for r in range(rows):
            pose = poses[0] if len(poses) == 1 else poses[2 * r + 1]
            half_y = 0.5 * (y_edges[r + 1] - y_edges[r])
            for c in range(columns):
                if states[r, c] != wanted:
                    continue
                half_x = 0.5 * (x_edges[c + 1] - x_edges[c])
                box = (x_edges[c] + half_x, y_edges[r] + half_y, half_x, half_y)
                stamps[-1] += 1
                queued = _seed(hits, r, c, 0 if wanted == COVER else 1, kinds.shape, queue, stamps)
                covered, sides = cover_cell(
                    pose, box, vertices, triangles, neighbors, queue, queued, stamps, stamps[-1], a, b, found
                )
                if covered < 0.0 or covered > FULL:
                    states[r, c] = OVERLAP
                    overlaps += 1
                    continue
                partial[r, c] = True
                modes[:, r, c] = found
                deepest = max(deepest, found[0])
                if wanted == COVER and sides:
                    poked += _poke(r, c, sides, states)
    return deepest, overlaps


@njit(cache=True, error_model="numpy", inline="always")
def _one_plane(corners: Floats, kinds: Ints, r: int, c: int, hx: float, hy: float) -> bool:
    """Whether the four corners of a cell lie on one plane."""
    if kinds[r, c] & kinds[r, c + 1] & kinds[r + 1, c] & kinds[r + 1, c + 1] != HIT:
        return False
    z, gx, gy = corners[0, r, c], corners[1, r, c], corners[2, r, c]
    bend = (
        abs(corners[1, r, c + 1] - gx) + abs(corners[1, r + 1, c] - gx) + abs(corners[1, r + 1, c + 1] - gx)
    )
    bend += (
        abs(corners[2, r, c + 1] - gy) + abs(corners[2, r + 1, c] - gy) + abs(corners[2, r + 1, c + 1] - gy)
    )
    miss = abs(corners[0, r, c + 1] - z - gx * hx) + abs(corners[0, r + 1, c] - z - gy * hy)
    return bool(bend < COPLANAR and miss < COPLANAR * (hx + hy))


@njit(cache=True, error_model="numpy")
def _seed(hits: Ints, r: int, c: int, reach: int, shape: tuple[int, int], queue: Ints, stamps: Ints) -> int:
    """Queue the triangles that the cell's corners met, and those of the corners up to `reach` around."""
    queued = 0
    for i in range(max(r - reach, 0), min(r + 2 + reach, shape[0])):
        for j in range(max(c - reach, 0), min(c + 2 + reach, shape[1])):
            t = hits[i * shape[1] + j]
            if t >= 0 and stamps[t] != stamps[-1]:
                stamps[t] = stamps[-1]
                queue[queued] = t
                queued += 1
    return queued


@njit(cache=True, error_model="numpy")
def _poke(r: int, c: int, sides: int, states: Ints) -> int:
    """Mark the empty cells across the sides that an indentation runs along."""
    marked = 0
    for bit, i, j in ((1, r, c - 1), (2, r, c + 1), (4, r - 1, c), (8, r + 1, c)):
        inside = i >= 0 and j >= 0 and i < states.shape[0] and j < states.shape[1]
        if sides & bit and inside and states[i, j] == EMPTY:
            states[i, j] = POKED
            marked += 1
    return marked
