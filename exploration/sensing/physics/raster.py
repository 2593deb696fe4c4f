"""The indentation by a few convex facets, drawn straight onto the skin's cells: exact, and no feature is missed.

A facet's sides are noted in the cells that they cross.  A cell that none crosses is wholly inside or outside, and
its depth linear; any other is clipped by the sides noted in it, which is exact because a convex facet lies on one
side of each (our derivation).  Rows that are scanned at poses of their own meet only what comes near them.
"""

import numpy as np
from numba import njit

from exploration.sensing.physics.coverage import add_polygon, clip_to_contact
from exploration.sensing.physics.facet_sides import (
    most_moved,
    note_sides,
    pick_facets,
    pick_sides,
    see,
    span,
)
from primitives.arrays import Bools, Floats, Ints

BEHIND = 10.0  # [mm] past the greatest press: deeper surfaces lie behind the sensor, not in its skin
_WALL = 1e-7  # cosine to the rays below which a facet is seen edge on
_MOST_CORNERS = 4096  # of a clipped cell: as many as the finest circle has sides


def drawing_room(cells: tuple[int, int], facets: int) -> tuple[Floats, Ints, Ints]:
    """Scratch: polygons, the first note of each cell, and notes (side, next)."""
    return (
        np.zeros((3, _MOST_CORNERS + 2, 3)),
        np.full(cells, -1, np.int64),
        np.zeros((4096 + facets, 2), np.int64),
    )


@njit(cache=True, error_model="numpy")
def draw(
    poses: Floats,
    x_edges: Floats,
    y_edges: Floats,
    floor: float,
    normals: Floats,
    start: Ints,
    loop: Floats,
    room: Floats,
    head: Ints,
    notes: Ints,
    covered: Floats,
    modes: Floats,
    partial: Bools,
) -> tuple[float, float]:
    """Fill (10, R, C) modes, the share of each cell that is indented, and `partial`; greatest depth and share."""
    modes[:] = 0.0
    covered[:] = 0.0
    partial[:] = False
    rows = len(y_edges) - 1
    deepest = 0.0
    seen, about, sides = np.empty((len(loop), 2)), np.empty((len(loop), 3)), np.empty(len(loop), np.int64)
    near, spans = np.empty(len(normals), np.int64), np.empty((len(normals), 2))
    middle = poses[len(poses) // 2]
    slack = most_moved(poses, middle, np.hypot(x_edges[-1], y_edges[-1]) - floor)
    see(middle, loop, about)
    listed = pick_facets(start, about, slack, x_edges, y_edges, near, spans)
    for group in range(1 if len(poses) == 1 else rows):
        whole = len(poses) == 1
        pose = poses[0] if whole else poses[2 * group + 1]
        first, last = (0, rows) if whole else (group, group + 1)
        for n in range(listed):
            f = near[n]
            if spans[n, 0] >= y_edges[last] or spans[n, 1] <= y_edges[first]:
                continue
            facing = normals[f, 0] * pose[0, 2] + normals[f, 1] * pose[1, 2] + normals[f, 2] * pose[2, 2]
            if facing >= -_WALL:
                continue
            count = pick_sides(start[f], start[f + 1], about, slack, y_edges[first], y_edges[last], sides)
            if count > 0:
                depth = _draw_facet(
                    f, facing, pose, first, last, x_edges, y_edges, floor,
                    normals, start, loop, seen, sides[:count], room, head, notes, covered, modes, partial,
                )  # fmt: skip
                deepest = max(deepest, depth)
    return deepest, covered.max()


@njit(cache=True, error_model="numpy")
def _draw_facet(
    f: int,
    facing: float,
    pose: Floats,
    first: int,
    last: int,
    x_edges: Floats,
    y_edges: Floats,
    floor: float,
    normals: Floats,
    start: Ints,
    loop: Floats,
    seen: Floats,
    sides: Ints,
    room: Floats,
    head: Ints,
    notes: Ints,
    covered: Floats,
    modes: Floats,
    partial: Bools,
) -> float:
    s0, s1 = start[f], start[f + 1]
    x_low = y_low = z_low = np.inf
    x_high = y_high = z_high = -np.inf
    for k in range(2 * len(sides)):
        i = sides[k // 2]
        if k % 2 == 1:
            i = i + 1 if i + 1 < s1 else s0
            if k // 2 + 1 < len(sides) and sides[k // 2 + 1] == i:
                continue
        dx, dy, dz = loop[i, 0] - pose[0, 3], loop[i, 1] - pose[1, 3], loop[i, 2] - pose[2, 3]
        x = pose[0, 0] * dx + pose[1, 0] * dy + pose[2, 0] * dz
        y = pose[0, 1] * dx + pose[1, 1] * dy + pose[2, 1] * dz
        z = pose[0, 2] * dx + pose[1, 2] * dy + pose[2, 2] * dz
        seen[i, 0], seen[i, 1] = x, y
        x_low, x_high = min(x_low, x), max(x_high, x)
        y_low, y_high = min(y_low, y), max(y_high, y)
        z_low, z_high = min(z_low, z), max(z_high, z)
    if z_low >= 0.0 or z_high < floor or x_low >= x_edges[-1] or x_high <= x_edges[0]:
        return 0.0
    if y_low >= y_edges[last] or y_high <= y_edges[first]:
        return 0.0
    gx = -(normals[f, 0] * pose[0, 0] + normals[f, 1] * pose[1, 0] + normals[f, 2] * pose[2, 0]) / facing
    gy = -(normals[f, 0] * pose[0, 1] + normals[f, 1] * pose[1, 1] + normals[f, 2] * pose[2, 1]) / facing
    z0 = 0.0
    for k in range(3):
        z0 += normals[f, k] * (loop[s0, k] - pose[k, 3])
    z0 /= facing
    left, right = 0, len(x_edges) - 2
    while x_edges[left + 1] <= x_low:
        left += 1
    while x_edges[right] >= x_high:
        right -= 1
    while y_edges[first + 1] <= y_low:
        first += 1
    while y_edges[last - 1] >= y_high:
        last -= 1
    for r in range(first, last):
        for c in range(left, right + 1):
            head[r, c] = -1
    note_sides(s0, s1, sides, seen, x_edges, y_edges, first, last, left, right, head, notes)
    a, b = room[0], room[1]
    found = np.zeros(len(modes))
    deepest = 0.0
    for r in range(first, last):
        half_y = 0.5 * (y_edges[r + 1] - y_edges[r])
        y = y_edges[r] + half_y
        in_from, in_to = span(s0, s1, sides, seen, y)
        for c in range(left, right + 1):
            half_x = 0.5 * (x_edges[c + 1] - x_edges[c])
            x = x_edges[c] + half_x
            if head[r, c] < 0 and not in_from < x < in_to:
                continue
            depth, tilt_x, tilt_y = -(z0 + gx * x + gy * y), -gx * half_x, -gy * half_y
            swing = abs(tilt_x) + abs(tilt_y)
            if depth + swing <= 0.0 or depth - swing > -floor:
                continue
            if head[r, c] < 0 and depth >= swing:
                modes[0, r, c] += depth
                modes[1, r, c] += tilt_x
                modes[2, r, c] += tilt_y
                covered[r, c] += 1.0
                deepest = max(deepest, depth + swing)
                continue
            count = _cell(a, depth, tilt_x, tilt_y)
            note = head[r, c]
            while note >= 0 and count >= 3:
                i = notes[note, 0]
                j = i + 1 if i + 1 < s1 else s0
                nx, ny = (seen[i, 1] - seen[j, 1]) * half_x, (seen[j, 0] - seen[i, 0]) * half_y
                at = (seen[j, 0] - seen[i, 0]) * (seen[i, 1] - y) - (seen[j, 1] - seen[i, 1]) * (
                    seen[i, 0] - x
                )
                count = _clip_side(a, count, b, nx, ny, at)
                note = notes[note, 1]
            count = clip_to_contact(a, b, count) if count >= 3 else 0
            if count == 0:
                continue
            found[:] = 0.0
            covered[r, c] += add_polygon(a, count, found)
            for m in range(len(found)):
                modes[m, r, c] += found[m]
            for i in range(count):
                deepest = max(deepest, -a[i, 2])
            partial[r, c] = True
    return deepest


@njit(cache=True, error_model="numpy")
def _cell(p: Floats, depth: float, tilt_x: float, tilt_y: float) -> int:
    """The whole cell as a polygon."""
    for i in range(4):
        p[i, 0] = -1.0 if i == 0 or i == 3 else 1.0
        p[i, 1] = -1.0 if i < 2 else 1.0
        p[i, 2] = -(depth + tilt_x * p[i, 0] + tilt_y * p[i, 1])
    return 4


@njit(cache=True, error_model="numpy")
def _clip_side(p: Floats, count: int, spare: Floats, nx: float, ny: float, at: float) -> int:
    """Keep what has nx x + ny y <= at, in place."""
    kept = 0
    ends = min(count, _MOST_CORNERS)
    bx, by, bz = p[ends - 1, 0], p[ends - 1, 1], p[ends - 1, 2]
    b = nx * bx + ny * by - at
    for i in range(ends):
        ax, ay, az, a = bx, by, bz, b
        bx, by, bz = p[i, 0], p[i, 1], p[i, 2]
        b = nx * bx + ny * by - at
        if (a < 0.0 < b) or (b < 0.0 < a):
            s = a / (a - b)
            spare[kept, 0], spare[kept, 1], spare[kept, 2] = (
                ax + s * (bx - ax),
                ay + s * (by - ay),
                az + s * (bz - az),
            )
            kept += 1
        if b <= 0.0:
            spare[kept, 0], spare[kept, 1], spare[kept, 2] = bx, by, bz
            kept += 1
    for i in range(kept):
        p[i, 0], p[i, 1], p[i, 2] = spare[i, 0], spare[i, 1], spare[i, 2]
    return kept
