"""Compiled: Gauss-Newton on a pose without allocating; a pose is object_from_world, a (3, 4) array.

For a point q that moves by v + w x (q - c), its distance d along the unit u from the surface's point s changes by
u . v + (r x u) . w with r = s - c: u turns along with s, where the surface bends.  A normal m turns by w x m; the
surface's own normal n, where it bends, goes along with the point by k (v + w x r), with k the shape operator, so
that m - n changes by w x m - k (v + w x r).  In the squared gradient w x n stands for w x m, whose slope is the
same: a normal that is off by noise would else seem to tell of turns about the surface's own.  On a plane k is 0
(our derivation).
"""

import numpy as np
from numba import njit


@njit(cache=True, nogil=True, inline="always")
def moved(pose, p, out):  # type: ignore[no-untyped-def]
    """A (3,) point carried by a pose into `out`."""
    for i in range(3):
        out[i] = pose[i, 0] * p[0] + pose[i, 1] * p[1] + pose[i, 2] * p[2] + pose[i, 3]


@njit(cache=True, nogil=True, inline="always")
def rotated(pose, n, out):  # type: ignore[no-untyped-def]
    """A (3,) direction carried by a pose into `out`."""
    for i in range(3):
        out[i] = pose[i, 0] * n[0] + pose[i, 1] * n[1] + pose[i, 2] * n[2]


@njit(cache=True, nogil=True)
def add_distance(h, b, r, u, d, weight, j):  # type: ignore[no-untyped-def]
    """Into the lower half of h (6, 6) and b (6,): a distance d along u at r from the center; `j` is scratch."""
    j[0], j[1], j[2] = u[0], u[1], u[2]
    j[3], j[4], j[5] = r[1] * u[2] - r[2] * u[1], r[2] * u[0] - r[0] * u[2], r[0] * u[1] - r[1] * u[0]
    for p in range(6):
        b[p] -= weight * d * j[p]
        for o in range(p + 1):
            h[p, o] += weight * j[p] * j[o]


@njit(cache=True, nogil=True)
def add_normal(h, b, m, n, weight):  # type: ignore[no-untyped-def]
    """Into h and b: a felt normal m that should be n."""
    x, y, z = m[0] - n[0], m[1] - n[1], m[2] - n[2]
    b[3] -= weight * (m[1] * z - m[2] * y)
    b[4] -= weight * (m[2] * x - m[0] * z)
    b[5] -= weight * (m[0] * y - m[1] * x)
    for p in range(3):
        for o in range(p + 1):
            h[p + 3, o + 3] += weight * ((1.0 if p == o else 0.0) - m[p] * m[o])


@njit(cache=True, nogil=True)
def add_bent_normal(h, b, m, n, k, r, weight, j):  # type: ignore[no-untyped-def]
    """Into h and b: a felt normal m that should be n at r, where the surface bends by k (3, 3) [1/mm].

    What a facet's k has along n, between whose corners normals turn, is left out: no unit vector changes so.
    """
    for a in range(3):
        off = m[a] - n[a]
        c, d = (a + 1) % 3, (a + 2) % 3
        x = k[a, 0] - n[a] * (n[0] * k[0, 0] + n[1] * k[1, 0] + n[2] * k[2, 0])
        y = k[a, 1] - n[a] * (n[0] * k[0, 1] + n[1] * k[1, 1] + n[2] * k[2, 1])
        z = k[a, 2] - n[a] * (n[0] * k[0, 2] + n[1] * k[1, 2] + n[2] * k[2, 2])
        j[0], j[1], j[2] = -x, -y, -z
        j[3] = y * r[2] - z * r[1]
        j[4] = z * r[0] - x * r[2]
        j[5] = x * r[1] - y * r[0]
        j[3 + c] += n[d]
        j[3 + d] -= n[c]
        for p in range(6):
            b[p] -= weight * off * j[p]
            for o in range(p + 1):
                h[p, o] += weight * j[p] * j[o]


@njit(cache=True, nogil=True)
def solved(h, b, x):  # type: ignore[no-untyped-def]
    """Solve h x = b for x by Cholesky, in place of the lower half of h; false where h is not positive."""
    for i in range(6):
        for k in range(i + 1):
            total = h[i, k]
            for m in range(k):
                total -= h[i, m] * h[k, m]
            if i > k:
                h[i, k] = total / h[k, k]
            elif total <= 0.0:
                return False
            else:
                h[i, i] = np.sqrt(total)
    for i in range(6):
        total = b[i]
        for m in range(i):
            total -= h[i, m] * x[m]
        x[i] = total / h[i, i]
    for i in range(5, -1, -1):
        total = x[i]
        for m in range(i + 1, 6):
            total -= h[m, i] * x[m]
        x[i] = total / h[i, i]
    return True


@njit(cache=True, nogil=True)
def turn(pose, x, center):  # type: ignore[no-untyped-def]
    """Move by x = (v, w) about `center`, in place: q becomes center + v + R(w) (q - center)."""
    angle = np.sqrt(x[3] * x[3] + x[4] * x[4] + x[5] * x[5])
    ax, ay, az, s, c = 0.0, 0.0, 0.0, 0.0, 1.0
    if angle > 1e-12:
        ax, ay, az = x[3] / angle, x[4] / angle, x[5] / angle
        angle = min(angle, 0.5)
        s, c = np.sin(angle), np.cos(angle)
    for i in range(4):
        px, py, pz = pose[0, i], pose[1, i], pose[2, i]
        if i == 3:
            px, py, pz = px - center[0], py - center[1], pz - center[2]
        along = (ax * px + ay * py + az * pz) * (1.0 - c)
        pose[0, i] = c * px + s * (ay * pz - az * py) + along * ax
        pose[1, i] = c * py + s * (az * px - ax * pz) + along * ay
        pose[2, i] = c * pz + s * (ax * py - ay * px) + along * az
    for i in range(3):
        pose[i, 3] += center[i] + x[i]
