"""What rays at the corners of the skin's cells say: each corner's height and slope, and which cells are simple.

A cell's four corners see every straight edge that crosses it.  Where the corner planes predict each other,
the surface is taken as the quadratic through them,

    mean = corners' mean - (hx dgx + hy dgy) / 12 ,   g the slope, d its change across the cell,

else the cell is left to `coverage`.  Prediction is judged by the trapezoid rule for slopes, exact for quadratics:
z_b - z_a = (g_a + g_b) h / 2.
"""

import numpy as np
from numba import njit

from exploration.sensing.physics.coverage import add_polygon, clip_to_contact
from exploration.sensing.physics.slipped_rays import HIT, INSIDE, MISS, plane_of
from primitives.arrays import Floats, Ints

EMPTY, SIMPLE, COVER = 0, 1, 2
COPLANAR = 1e-5  # change of slope, and mismatch over width, below which corners lie on one plane
_MISMATCH = 0.15  # of the change of slope times the width: what facets of a smooth surface may show
_FACET_NOISE = 0.002  # [mm]
_BENT = 0.5  # change of slope across a cell beyond which it is an edge
_FINE = 0.25  # facets narrower than this share of a cell count as a smooth surface
_FAR = 3.0  # [cells] above the skin, where nothing can reach it within a cell
_SPLIT = 8  # samples along a side, where a smooth surface leaves the skin


@njit(cache=True, error_model="numpy")
def read_corners(
    hits: Ints,
    poses: Floats,
    x_edges: Floats,
    y_edges: Floats,
    vertices: Floats,
    triangles: Ints,
    start: float,
    corners: Floats,
    kinds: Ints,
) -> float:
    """Fill (3, R + 1, C + 1) heights and slopes and their kinds; the greatest depth."""
    rows, columns = kinds.shape
    far = _FAR * max(x_edges[-1] - x_edges[-2], y_edges[-1] - y_edges[-2])
    deepest, last, last_pose = 0.0, -1, -1
    z0 = gx = gy = facing = 0.0
    for r in range(rows):
        k = 0 if len(poses) == 1 else 2 * r
        pose = poses[k]
        for c in range(columns):
            t = hits[r * columns + c]
            if t < 0:
                kinds[r, c] = MISS
                continue
            if t != last or k != last_pose:
                z0, gx, gy, facing = plane_of(pose, vertices, triangles, t)
                last, last_pose = t, k
            if facing >= 0.0:
                kinds[r, c] = INSIDE
                corners[0, r, c], corners[1, r, c], corners[2, r, c] = -start, 0.0, 0.0
                deepest = start
                continue
            z = z0 + gx * x_edges[c] + gy * y_edges[r]
            kinds[r, c] = HIT if z < far else MISS
            corners[0, r, c], corners[1, r, c], corners[2, r, c] = z, gx, gy
            deepest = max(deepest, -z)
    return deepest


@njit(cache=True, error_model="numpy")
def judge(
    r: int,
    c: int,
    corners: Floats,
    kinds: Ints,
    hits: Ints,
    hx: float,
    hy: float,
    vertices: Floats,
    triangles: Ints,
) -> int:
    """Whether a cell is empty, simple, or needs exact coverage."""
    k00, k01, k10, k11 = kinds[r, c], kinds[r, c + 1], kinds[r + 1, c], kinds[r + 1, c + 1]
    if k00 == INSIDE or k01 == INSIDE or k10 == INSIDE or k11 == INSIDE:
        return SIMPLE
    first, row = hits[r * kinds.shape[1] + c], kinds.shape[1]
    if k00 & k01 & k10 & k11 == HIT:
        below = hits[(r + 1) * row + c]
        if first == hits[r * row + c + 1] and first == below and first == hits[(r + 1) * row + c + 1]:
            return SIMPLE
    reached = False
    for i in range(2):
        for j in range(2):
            if kinds[r + i, c + j] == HIT:
                gx, gy = corners[1, r + i, c + j], corners[2, r + i, c + j]
                low = corners[0, r + i, c + j] + min(0.0, gx * hx if j == 0 else -gx * hx)
                reached = reached or low + min(0.0, gy * hy if i == 0 else -gy * hy) < 0.0
    if not reached:
        return EMPTY
    if k00 & k01 & k10 & k11 != HIT:
        return COVER
    bend = miss = 0.0
    for k in range(2):
        dx = corners[1, r + k, c + 1] - corners[1, r + k, c]
        dy = corners[2, r + 1, c + k] - corners[2, r, c + k]
        across = abs(corners[2, r + k, c + 1] - corners[2, r + k, c])
        bend = max(bend, abs(dx), abs(dy), across)
        rise_x = corners[0, r + k, c + 1] - corners[0, r + k, c]
        rise_y = corners[0, r + 1, c + k] - corners[0, r, c + k]
        miss = max(miss, abs(rise_x - 0.5 * hx * (corners[1, r + k, c + 1] + corners[1, r + k, c])))
        miss = max(miss, abs(rise_y - 0.5 * hy * (corners[2, r + 1, c + k] + corners[2, r, c + k])))
    width = max(hx, hy)
    if bend < COPLANAR and miss < COPLANAR * width:
        return SIMPLE
    if bend > _BENT or miss > _MISMATCH * bend * width + _FACET_NOISE:
        return COVER
    other = hits[(r + 1) * row + c + 1]
    fine = _FINE * min(hx, hy)
    if _narrow(vertices, triangles, first) < fine and _narrow(vertices, triangles, other) < fine:
        return SIMPLE
    return COVER


@njit(cache=True, error_model="numpy")
def _narrow(vertices: Floats, triangles: Ints, t: int) -> float:
    """The least altitude of a triangle."""
    longest = 0.0
    a, b, c = vertices[triangles[t, 0]], vertices[triangles[t, 1]], vertices[triangles[t, 2]]
    for p, q in ((a, b), (b, c), (c, a)):
        longest = max(longest, (q[0] - p[0]) ** 2 + (q[1] - p[1]) ** 2 + (q[2] - p[2]) ** 2)
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    return float(np.sqrt((nx * nx + ny * ny + nz * nz) / longest))


@njit(cache=True, error_model="numpy")
def simple_cell(
    r: int, c: int, corners: Floats, hx: float, hy: float, a: Floats, b: Floats, modes: Floats
) -> None:
    """Integrate the quadratic through the corners, as far as it is in contact."""
    d00, d01 = -corners[0, r, c], -corners[0, r, c + 1]
    d10, d11 = -corners[0, r + 1, c], -corners[0, r + 1, c + 1]
    gx0 = corners[1, r, c] + corners[1, r + 1, c]
    gx1 = corners[1, r, c + 1] + corners[1, r + 1, c + 1]
    gy0 = corners[2, r, c] + corners[2, r, c + 1]
    gy1 = corners[2, r + 1, c] + corners[2, r + 1, c + 1]
    bend_x, bend_y = -(gx1 - gx0) * hx / 24.0, -(gy1 - gy0) * hy / 24.0
    least, most = min(d00, d01, d10, d11), max(d00, d01, d10, d11)
    slack = 1.5 * (abs(bend_x) + abs(bend_y))
    if most + slack <= 0.0:
        modes[:] = 0.0
        return
    modes[0] = 0.25 * (d00 + d01 + d10 + d11) - bend_x - bend_y
    modes[1] = 0.25 * (d01 + d11 - d00 - d10)
    modes[2] = 0.25 * (d10 + d11 - d00 - d01)
    modes[3] = bend_x
    modes[4] = 0.25 * (d00 + d11 - d01 - d10)
    modes[5] = bend_y
    modes[6:] = 0.0
    if least - slack >= 0.0:
        return
    if slack < 1e-6 and abs(modes[4]) < 1e-6:
        a[0, 0], a[0, 1], a[0, 2] = -1.0, -1.0, -d00
        a[1, 0], a[1, 1], a[1, 2] = 1.0, -1.0, -d01
        a[2, 0], a[2, 1], a[2, 2] = 1.0, 1.0, -d11
        a[3, 0], a[3, 1], a[3, 2] = -1.0, 1.0, -d10
        count = clip_to_contact(a, b, 4)
        modes[:] = 0.0
        add_polygon(a, count, modes)
        return
    _sample(modes)


@njit(cache=True, error_model="numpy")
def _sample(modes: Floats) -> None:
    """Replace the modes of a quadratic by those of its part above zero."""
    m0, m1, m2, m3, m4, m5 = modes[:6]
    modes[:] = 0.0
    for i in range(_SPLIT):
        v = (2 * i + 1) / _SPLIT - 1.0
        for j in range(_SPLIT):
            u = (2 * j + 1) / _SPLIT - 1.0
            pu, pv = 1.5 * u * u - 0.5, 1.5 * v * v - 0.5
            d = m0 + m1 * u + m2 * v + m3 * pu + m4 * u * v + m5 * pv
            if d > 0.0:
                d /= _SPLIT * _SPLIT
                modes[0] += d
                modes[1] += 3.0 * d * u
                modes[2] += 3.0 * d * v
                modes[3] += 5.0 * d * pu
                modes[4] += 9.0 * d * u * v
                modes[5] += 5.0 * d * pv
                modes[6] += 3.5 * d * u * (5.0 * u * u - 3.0)
                modes[7] += 15.0 * d * pu * v
                modes[8] += 15.0 * d * u * pv
                modes[9] += 3.5 * d * v * (5.0 * v * v - 3.0)
