"""The indentation by a few triangles, drawn straight onto the skin's cells: exact, and no feature is missed.

A triangle either covers a cell, whose depth is then linear, or is clipped to it (see `coverage`).  The triangles
near the pad are listed once and again only when the pad has moved by the list's slack, as in molecular dynamics
(Verlet 1967).
"""

from math import dist

import numpy as np
from numba import njit

from exploration.sensing.coverage import add_polygon, clip_to_cell, clip_to_contact
from primitives.arrays import Bools, Floats, Ints

BEHIND = 10.0  # [mm] past the greatest press: deeper surfaces lie behind the sensor, not in its skin
_SLACK = 5.0  # [mm] that the pad may move before triangles are listed again
_WALL = 1e-9  # [mm^2] less projected area is a wall, seen edge on


class NearTriangles:
    """The triangles of a mesh that a ball of given radius [mm] may meet."""

    slack = _SLACK

    def __init__(self, vertices: Floats, triangles: Ints, radius: float) -> None:
        self._all_vertices, self._all_triangles = vertices, triangles
        self._radius = radius + _SLACK
        corners = vertices[triangles]
        self._low, self._high = corners.min(axis=1), corners.max(axis=1)
        self._center: tuple[float, float, float] | None = None
        self.vertices = np.zeros((0, 3))  # (v, 3) [mm]
        self.triangles = np.zeros((0, 3), np.int32)  # (t, 3) into `vertices`
        self.seen = np.zeros((0, 3))  # (v, 3) scratch

    def around(self, x: float, y: float, z: float) -> float:
        """Bring the list up to date; how far the ball may move [mm] before it must be asked again."""
        if self._center is not None:
            left = _SLACK - dist((x, y, z), self._center)
            if left >= 0.0:
                return left
        self._center = (float(x), float(y), float(z))
        center = np.array(self._center)
        away = np.maximum(0.0, np.maximum(self._low - center, center - self._high))
        near = self._all_triangles[np.flatnonzero((away * away).sum(axis=1) <= self._radius**2)]
        used, renamed = np.unique(near, return_inverse=True)
        self.vertices = np.ascontiguousarray(self._all_vertices[used])
        self.triangles = renamed.reshape(-1, 3).astype(np.int32)
        self.seen = np.zeros_like(self.vertices)
        return _SLACK


@njit(cache=True, error_model="numpy")
def draw(
    poses: Floats,
    x_edges: Floats,
    y_edges: Floats,
    floor: float,
    vertices: Floats,
    triangles: Ints,
    seen: Floats,
    clip: Floats,
    covered: Floats,
    modes: Floats,
    partial: Bools,
) -> float:
    """Fill (6, R, C) modes, the share of each cell that is indented, and `partial`; the greatest depth."""
    modes[:] = 0.0
    covered[:] = 0.0
    partial[:] = False
    rows = len(y_edges) - 1
    if len(poses) == 1:
        whole = _draw_rows(
            poses[0],
            0,
            rows,
            x_edges,
            y_edges,
            floor,
            vertices,
            triangles,
            seen,
            clip,
            covered,
            modes,
            partial,
        )
        return float(whole)
    deepest = 0.0
    for r in range(rows):
        pose = poses[2 * r + 1]
        depth = _draw_rows(
            pose, r, r + 1, x_edges, y_edges, floor, vertices, triangles, seen, clip, covered, modes, partial
        )
        deepest = max(deepest, depth)
    return deepest


@njit(cache=True, error_model="numpy")
def _draw_rows(
    pose: Floats,
    first: int,
    last: int,
    x_edges: Floats,
    y_edges: Floats,
    floor: float,
    vertices: Floats,
    triangles: Ints,
    seen: Floats,
    clip: Floats,
    covered: Floats,
    modes: Floats,
    partial: Bools,
) -> float:
    columns = len(x_edges) - 1
    for i in range(len(vertices)):
        dx, dy, dz = vertices[i, 0] - pose[0, 3], vertices[i, 1] - pose[1, 3], vertices[i, 2] - pose[2, 3]
        seen[i, 0] = pose[0, 0] * dx + pose[1, 0] * dy + pose[2, 0] * dz
        seen[i, 1] = pose[0, 1] * dx + pose[1, 1] * dy + pose[2, 1] * dz
        seen[i, 2] = pose[0, 2] * dx + pose[1, 2] * dy + pose[2, 2] * dz
    lowest = 0.0
    a, b = clip[0], clip[1]
    found = clip[2, 0:2].reshape(6)
    for t in range(len(triangles)):
        p, q, s = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        z_low = min(seen[p, 2], seen[q, 2], seen[s, 2])
        if z_low >= 0.0 or max(seen[p, 2], seen[q, 2], seen[s, 2]) < floor:
            continue
        ux, uy = seen[q, 0] - seen[p, 0], seen[q, 1] - seen[p, 1]
        vx, vy = seen[s, 0] - seen[p, 0], seen[s, 1] - seen[p, 1]
        turn = ux * vy - vx * uy
        if turn > -_WALL:
            continue
        x_low, x_high = min(seen[p, 0], seen[q, 0], seen[s, 0]), max(seen[p, 0], seen[q, 0], seen[s, 0])
        y_low, y_high = min(seen[p, 1], seen[q, 1], seen[s, 1]), max(seen[p, 1], seen[q, 1], seen[s, 1])
        if x_low >= x_edges[-1] or x_high <= x_edges[0] or y_low >= y_edges[last] or y_high <= y_edges[first]:
            continue
        uz, vz = seen[q, 2] - seen[p, 2], seen[s, 2] - seen[p, 2]
        gx, gy = (uz * vy - vz * uy) / turn, (vz * ux - uz * vx) / turn
        z0 = seen[p, 2] - gx * seen[p, 0] - gy * seen[p, 1]
        # Three edges as n . (x, y) + c, positive inside.
        ax, ay = uy, -ux
        bx, by = seen[s, 1] - seen[q, 1], seen[q, 0] - seen[s, 0]
        cx, cy = -vy, vx
        a0 = -(ax * seen[p, 0] + ay * seen[p, 1])
        b0 = -(bx * seen[q, 0] + by * seen[q, 1])
        c0 = -(cx * seen[s, 0] + cy * seen[s, 1])
        if ax * seen[s, 0] + ay * seen[s, 1] + a0 < 0.0:
            ax, ay, a0, bx, by, b0, cx, cy, c0 = -ax, -ay, -a0, -bx, -by, -b0, -cx, -cy, -c0
        for r in range(first, last):
            if y_edges[r] >= y_high or y_edges[r + 1] <= y_low:
                continue
            half_y = 0.5 * (y_edges[r + 1] - y_edges[r])
            y = y_edges[r] + half_y
            for c in range(columns):
                if x_edges[c] >= x_high or x_edges[c + 1] <= x_low:
                    continue
                half_x = 0.5 * (x_edges[c + 1] - x_edges[c])
                x = x_edges[c] + half_x
                ea, sa = ax * x + ay * y + a0, abs(ax) * half_x + abs(ay) * half_y
                eb, sb = bx * x + by * y + b0, abs(bx) * half_x + abs(by) * half_y
                ec, sc = cx * x + cy * y + c0, abs(cx) * half_x + abs(cy) * half_y
                if ea <= -sa or eb <= -sb or ec <= -sc:
                    continue
                depth, tilt_x, tilt_y = -(z0 + gx * x + gy * y), -gx * half_x, -gy * half_y
                swing = abs(tilt_x) + abs(tilt_y)
                if depth + swing <= 0.0 or depth - swing > -floor:
                    continue
                whole = ea >= sa and eb >= sb and ec >= sc
                if whole and depth >= swing:
                    modes[0, r, c] += depth
                    modes[1, r, c] += tilt_x
                    modes[2, r, c] += tilt_y
                    covered[r, c] += 1.0
                    lowest = min(lowest, -depth - swing)
                    continue
                if whole:
                    count = 4
                    for i in range(4):
                        a[i, 0] = -1.0 if i == 0 or i == 3 else 1.0
                        a[i, 1] = -1.0 if i < 2 else 1.0
                        a[i, 2] = -(depth + tilt_x * a[i, 0] + tilt_y * a[i, 1])
                else:
                    for i in range(3):
                        k = triangles[t, i]
                        a[i, 0], a[i, 1] = (seen[k, 0] - x) / half_x, (seen[k, 1] - y) / half_y
                        a[i, 2] = seen[k, 2]
                    count = clip_to_cell(a, b, 3)
                    if count == 0:
                        continue
                count = clip_to_contact(a, b, count)
                if count == 0:
                    continue
                found[:] = 0.0
                covered[r, c] += add_polygon(a, count, found)
                for m in range(6):
                    modes[m, r, c] += found[m]
                for i in range(count):
                    lowest = min(lowest, a[i, 2])
                partial[r, c] = True
    return -lowest
