"""Exact integrals of a triangulated surface's depth over one cell of the skin.

Each front-facing triangle is clipped to the cell and to z < 0 (Sutherland and Hodgman 1974), and -z times each
Legendre mode is integrated over what is left, fanned into triangles with the six-point rule that is exact for
quartics (Strang and Fix 1973).  Inside a cell x and y run from -1 to 1; z stays in mm.
"""

import numpy as np
from numba import njit

from primitives.arrays import Floats, Ints

FULL = 1.0 + 1e-6  # share of a cell beyond which triangles must overlap each other
_FLAT = 1e-12  # squares of the cell; less projected area is a wall
_INNER = (
    0.108103018168070,
    0.445948490915965,
    0.223381589678011,
)  # one weight, the others, share of the area
_OUTER = (0.816847572980459, 0.091576213509771, 0.109951743655322)
_CORNERS = 12  # a triangle clipped by five planes has at most eight


@njit(cache=True, error_model="numpy")
def clip(p: Floats, count: int, spare: Floats, axis: int, sign: float, bound: float) -> int:
    """Keep what has sign * coordinate <= bound, in place; how many corners are left."""
    kept = 0
    bx, by, bz = p[count - 1, 0], p[count - 1, 1], p[count - 1, 2]
    b = sign * p[count - 1, axis] - bound
    for i in range(count):
        ax, ay, az, a = bx, by, bz, b
        bx, by, bz, b = p[i, 0], p[i, 1], p[i, 2], sign * p[i, axis] - bound
        if (a < 0.0 < b) or (b < 0.0 < a):
            s = a / (a - b)
            spare[kept, 0], spare[kept, 1], spare[kept, 2] = (
                ax + s * (bx - ax),
                ay + s * (by - ay),
                az + s * (bz - az),
            )
            spare[kept, axis] = sign * bound
            kept += 1
        if b <= 0.0:
            spare[kept, 0], spare[kept, 1], spare[kept, 2] = bx, by, bz
            kept += 1
    for i in range(kept):
        p[i, 0], p[i, 1], p[i, 2] = spare[i, 0], spare[i, 1], spare[i, 2]
    return kept


@njit(cache=True, error_model="numpy")
def add_polygon(p: Floats, count: int, modes: Floats) -> float:
    """Add the depth integrals of a polygon to ten modes; the share of the cell that it covers."""
    covered = 0.0
    for k in range(1, count - 1):
        area = 0.5 * abs(
            (p[k, 0] - p[0, 0]) * (p[k + 1, 1] - p[0, 1]) - (p[k + 1, 0] - p[0, 0]) * (p[k, 1] - p[0, 1])
        )
        covered += area
        for q in range(6):
            far, near, share = _INNER if q < 3 else _OUTER
            wa = far if q % 3 == 0 else near
            wb = far if q % 3 == 1 else near
            wc = far if q % 3 == 2 else near
            w = share * area
            u = wa * p[0, 0] + wb * p[k, 0] + wc * p[k + 1, 0]
            v = wa * p[0, 1] + wb * p[k, 1] + wc * p[k + 1, 1]
            d = -0.25 * w * (wa * p[0, 2] + wb * p[k, 2] + wc * p[k + 1, 2])
            modes[0] += d
            modes[1] += 3.0 * d * u
            modes[2] += 3.0 * d * v
            pu, pv = 2.5 * d * (3.0 * u * u - 1.0), 2.5 * d * (3.0 * v * v - 1.0)
            modes[3] += pu
            modes[4] += 9.0 * d * u * v
            modes[5] += pv
            modes[6] += 3.5 * d * u * (5.0 * u * u - 3.0)
            modes[7] += 3.0 * pu * v
            modes[8] += 3.0 * pv * u
            modes[9] += 3.5 * d * v * (5.0 * v * v - 3.0)
    return covered / 4.0


@njit(cache=True, error_model="numpy")
def clip_to_cell(a: Floats, b: Floats, count: int) -> int:
    """Clip the polygon in `a` to the cell, in place; `b` is scratch."""
    for axis in range(2):
        low, high = a[0, axis], a[0, axis]
        for i in range(1, count):
            low, high = min(low, a[i, axis]), max(high, a[i, axis])
        if low >= 1.0 or high <= -1.0:
            return 0
        if high > 1.0:
            count = clip(a, count, b, axis, 1.0, 1.0)
        if low < -1.0 and count >= 3:
            count = clip(a, count, b, axis, -1.0, 1.0)
        if count < 3:
            return 0
    return count


@njit(cache=True, error_model="numpy")
def clip_to_contact(a: Floats, b: Floats, count: int) -> int:
    """Clip the polygon in `a` to z <= 0, in place."""
    low, high = a[0, 2], a[0, 2]
    for i in range(1, count):
        low, high = min(low, a[i, 2]), max(high, a[i, 2])
    if low >= 0.0:
        return 0
    if high > 0.0:
        count = clip(a, count, b, 2, 1.0, 0.0)
    return count if count >= 3 else 0


@njit(cache=True, error_model="numpy")
def touched_sides(p: Floats, count: int) -> int:
    """Which sides of the cell a polygon runs along, as bits: left 1, right 2, low 4, high 8."""
    sides = 0
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        if abs(p[i, 0] - p[j, 0]) < 1e-9 and abs(p[i, 1] - p[j, 1]) > 1e-6:
            if p[i, 0] <= -1.0 + 1e-9:
                sides |= 1
            elif p[i, 0] >= 1.0 - 1e-9:
                sides |= 2
        elif abs(p[i, 1] - p[j, 1]) < 1e-9 and abs(p[i, 0] - p[j, 0]) > 1e-6:
            if p[i, 1] <= -1.0 + 1e-9:
                sides |= 4
            elif p[i, 1] >= 1.0 - 1e-9:
                sides |= 8
    return sides


@njit(cache=True, error_model="numpy")
def _apart(p: Floats) -> bool:
    """Whether a clockwise triangle lies outside the cell, by the separating axes of both."""
    if min(p[0, 0], p[1, 0], p[2, 0]) >= 1.0 or max(p[0, 0], p[1, 0], p[2, 0]) <= -1.0:
        return True
    if min(p[0, 1], p[1, 1], p[2, 1]) >= 1.0 or max(p[0, 1], p[1, 1], p[2, 1]) <= -1.0:
        return True
    jx, jy = p[2, 0], p[2, 1]
    for i in range(3):
        ix, iy = jx, jy
        jx, jy = p[i, 0], p[i, 1]
        nx, ny = jy - iy, ix - jx
        if abs(nx) + abs(ny) <= nx * ix + ny * iy:
            return True
    return False


@njit(cache=True, error_model="numpy")
def cover_cell(
    pose: Floats,
    box: tuple[float, float, float, float],
    vertices: Floats,
    triangles: Ints,
    neighbors: Ints,
    queue: Ints,
    queued: int,
    stamps: Ints,
    stamp: int,
    a: Floats,
    b: Floats,
    modes: Floats,
) -> tuple[float, int]:
    """Integrate over the cell `box` (x, y center, half width, half height) from seeds in `queue`.

    Spreads from seed to neighbor over front-facing triangles that overlap the cell.  Gives the share of the cell
    that is indented (-1 where the queue is too short) and the sides that the indentation touches.
    """
    x0, y0, half_x, half_y = box
    covered, sides, head = 0.0, 0, 0
    modes[:] = 0.0
    while head < queued:
        t = queue[head]
        head += 1
        for i in range(3):
            dx = vertices[triangles[t, i], 0] - pose[0, 3]
            dy = vertices[triangles[t, i], 1] - pose[1, 3]
            dz = vertices[triangles[t, i], 2] - pose[2, 3]
            a[i, 0] = (pose[0, 0] * dx + pose[1, 0] * dy + pose[2, 0] * dz - x0) / half_x
            a[i, 1] = (pose[0, 1] * dx + pose[1, 1] * dy + pose[2, 1] * dz - y0) / half_y
            a[i, 2] = pose[0, 2] * dx + pose[1, 2] * dy + pose[2, 2] * dz
        turn = (a[1, 0] - a[0, 0]) * (a[2, 1] - a[0, 1]) - (a[2, 0] - a[0, 0]) * (a[1, 1] - a[0, 1])
        if turn > -_FLAT or _apart(a):
            continue
        count = clip_to_cell(a, b, 3)
        if count == 0:
            continue
        for i in range(3):
            n = neighbors[t, i]
            if n >= 0 and stamps[n] != stamp:
                if queued == len(queue):
                    return -1.0, 0
                stamps[n] = stamp
                queue[queued] = n
                queued += 1
        count = clip_to_contact(a, b, count)
        if count:
            covered += add_polygon(a, count, modes)
            sides |= touched_sides(a, count)
    return covered, sides


def scratch() -> Floats:
    """Two polygons to clip in, and room for modes."""
    return np.zeros((3, _CORNERS, 3))
