"""Compiled: how well contacts lie on a distance field at a pose, and the pose's descent on it.

A pose is object_from_world, a (3, 4) array.  The cost of a contact is, with d the field's distance at it, g its
gradient and m the felt normal, both in the object's frame::

    min(d^2 / s^2, c) + w min(|m - g|^2 / a^2, c)

where s and a say how far from the truth the pose may still be, and w is the length of the gradient, 1 but where
the grid is too coarse for it: within a sheet thinner than a cell the two sides' gradients cancel, and say nothing.
"""

import numpy as np
from numba import njit

from recognition.matching.steps import add_distance, add_normal, moved, rotated, solved, turn


@njit(cache=True, nogil=True, inline="always")
def field_at(x, y, z, values, origin, spacing, step, out):  # type: ignore[no-untyped-def]
    """Distance and, in `out`, its unit gradient and its length before; outside as `models.library.field`."""
    ax, ay, az = (x - origin[0]) / spacing, (y - origin[1]) / spacing, (z - origin[2]) / spacing
    nx, ny, nz = values.shape[0] - 1, values.shape[1] - 1, values.shape[2] - 1
    ix, iy, iz = min(max(ax, 0.0), nx), min(max(ay, 0.0), ny), min(max(az, 0.0), nz)
    bx, by, bz = (ax - ix) * spacing, (ay - iy) * spacing, (az - iz) * spacing
    i, j, k = min(int(ix), nx - 1), min(int(iy), ny - 1), min(int(iz), nz - 1)
    u, v, w = ix - i, iy - j, iz - k
    v000, v100 = float(values[i, j, k]), float(values[i + 1, j, k])
    v010, v110 = float(values[i, j + 1, k]), float(values[i + 1, j + 1, k])
    v001, v101 = float(values[i, j, k + 1]), float(values[i + 1, j, k + 1])
    v011, v111 = float(values[i, j + 1, k + 1]), float(values[i + 1, j + 1, k + 1])
    c00, c10 = v000 + u * (v100 - v000), v010 + u * (v110 - v010)
    c01, c11 = v001 + u * (v101 - v001), v011 + u * (v111 - v011)
    c0, c1 = c00 + v * (c10 - c00), c01 + v * (c11 - c01)
    gz = c1 - c0
    gy = (1.0 - w) * (c10 - c00) + w * (c11 - c01)
    gx = (1.0 - w) * ((1.0 - v) * (v100 - v000) + v * (v110 - v010)) + w * (
        (1.0 - v) * (v101 - v001) + v * (v111 - v011)
    )
    d = step * (c0 + w * (c1 - c0))
    length = max(np.sqrt(gx * gx + gy * gy + gz * gz), 1e-12)
    out[3] = min(length * step / spacing, 1.0)
    gx, gy, gz = gx / length, gy / length, gz / length
    if bx != 0.0 or by != 0.0 or bz != 0.0:
        gx, gy, gz = bx + d * gx, by + d * gy, bz + d * gz
        d = np.sqrt(gx * gx + gy * gy + gz * gz)
        gx, gy, gz = gx / max(d, 1e-12), gy / max(d, 1e-12), gz / max(d, 1e-12)
    out[0], out[1], out[2] = gx, gy, gz
    return d


@njit(cache=True, nogil=True)
def cost_at(pose, points, normals, felt, s, a, c, limit, target, g):  # type: ignore[no-untyped-def]
    """Mean cost of all contacts, or more than `limit` as soon as it must be."""
    values, origin, spacing, step = target
    total, most = 0.0, limit * len(points)
    over, turn = 1.0 / (s * s), 1.0 / (a * a)
    for i in range(len(points)):
        p = points[i]
        x = pose[0, 0] * p[0] + pose[0, 1] * p[1] + pose[0, 2] * p[2] + pose[0, 3]
        y = pose[1, 0] * p[0] + pose[1, 1] * p[1] + pose[1, 2] * p[2] + pose[1, 3]
        z = pose[2, 0] * p[0] + pose[2, 1] * p[1] + pose[2, 2] * p[2] + pose[2, 3]
        d = field_at(x, y, z, values, origin, spacing, step, g)
        total += min(d * d * over, c)
        if felt[i]:
            n = normals[i]
            u = pose[0, 0] * n[0] + pose[0, 1] * n[1] + pose[0, 2] * n[2] - g[0]
            v = pose[1, 0] * n[0] + pose[1, 1] * n[1] + pose[1, 2] * n[2] - g[1]
            w = pose[2, 0] * n[0] + pose[2, 1] * n[1] + pose[2, 2] * n[2] - g[2]
            total += g[3] * min((u * u + v * v + w * w) * turn, c)
        if total > most:
            return limit + 1.0
    return total / max(len(points), 1)


@njit(cache=True, nogil=True)
def descend(pose, points, normals, felt, s, a, c, rounds, target):  # type: ignore[no-untyped-def]
    """Gauss-Newton with weights 1 / (1 + cost)^2 on the field, in place, about the contacts' middle."""
    values, origin, spacing, step = target
    g, j, b, x = np.empty(4), np.empty(6), np.empty(6), np.empty(6)
    q, m, r, center, middle = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.zeros(3)
    h = np.empty((6, 6))
    n = len(points)
    for i in range(n):
        for k in range(3):
            middle[k] += points[i, k] / n
    for _ in range(rounds):
        h[:], b[:] = 0.0, 0.0
        moved(pose, middle, center)
        far = 1.0
        for i in range(n):
            moved(pose, points[i], q)
            d = field_at(q[0], q[1], q[2], values, origin, spacing, step, g)
            for k in range(3):
                r[k] = q[k] - center[k]
            far = max(far, r[0] * r[0] + r[1] * r[1] + r[2] * r[2])
            add_distance(h, b, r, g, d, 1.0 / (1.0 + d * d / (s * s * c)) ** 2 / (s * s), j)
            if felt[i]:
                rotated(pose, normals[i], m)
                off = (m[0] - g[0]) ** 2 + (m[1] - g[1]) ** 2 + (m[2] - g[2]) ** 2
                add_normal(h, b, m, g, g[3] / (1.0 + off / (a * a * c)) ** 2 / (a * a))
        for k in range(3):
            h[k, k] += 0.002 * n / (s * s)
            h[k + 3, k + 3] += 0.002 * n * far / (s * s)
        if solved(h, b, x):
            turn(pose, x, center)
