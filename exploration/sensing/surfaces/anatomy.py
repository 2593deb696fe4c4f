"""The anatomy of a smooth surface, from its depth over the pad's plane: where it is deepest, and its shape there.

With g the gradient of the indentation at a point and H its (negated) Hessian, the outward normal is
(-gx, -gy, -1)/s, s^2 = 1 + |g|^2 (see `frame`), and the curvature in tangent axes is T^t H T / s, T the
coordinates of the tangent basis (convex is positive).
"""

import numba
import numpy as np

from exploration.sensing.surfaces.pressed_field import dome_at
from primitives.arrays import Bools, Floats

SIGNIFICANT = 4.0  # [sigma] of a principal curvature, for the contact point to follow it
STRAIGHT = 1e-5  # [1/mm] less is no curvature


@numba.njit(cache=True, error_model="numpy")
def anatomy(
    c: Floats, covariance: Floats, mask: Bools, x: Floats, y: Floats
) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Point, normal, tangent basis, curvature in the tangents, and its covariance."""
    at = _deepest(c, covariance, mask, x, y)
    depth, gx, gy = dome_at(c, at[0], at[1])
    scale = np.sqrt(1.0 + gx * gx + gy * gy)
    normal = np.array([-gx, -gy, -1.0]) / scale
    first = np.array([1.0, 0.0, 0.0]) - normal[0] * normal
    first /= np.sqrt(np.sum(first * first))
    basis = np.empty((3, 3))
    basis[:, 0], basis[:, 1], basis[:, 2] = first, np.cross(normal, first), normal
    turn = np.empty((3, 3))
    for row, (i, j) in enumerate(((0, 0), (0, 1), (1, 1))):
        a, b = basis[:2, i], basis[:2, j]
        turn[row] = np.array([a[0] * b[0], a[0] * b[1] + a[1] * b[0], a[1] * b[1]]) / scale
    k = turn @ c[3:]
    spread = turn @ np.ascontiguousarray(covariance[3:, 3:]) @ turn.T
    return np.array([at[0], at[1], -depth]), normal, basis, np.array([[k[0], k[1]], [k[1], k[2]]]), spread


@numba.njit(cache=True, error_model="numpy")
def _deepest(c: Floats, covariance: Floats, mask: Bools, x: Floats, y: Floats) -> Floats:
    """From the mask's centroid, along each curved principal direction, to the greatest depth within the mask."""
    count, cx, cy = 0, 0.0, 0.0
    for i in range(len(y)):
        for j in range(len(x)):
            if mask[i, j]:
                count += 1
                cx += x[j]
                cy += y[i]
    center = np.array([cx / max(1, count), cy / max(1, count)])
    out = center.copy()
    mean, half = 0.5 * (c[3] + c[5]), np.hypot(0.5 * (c[3] - c[5]), c[4])
    angle = 0.5 * np.arctan2(c[4], 0.5 * (c[3] - c[5]))
    gx = c[1] - c[3] * center[0] - c[4] * center[1]
    gy = c[2] - c[4] * center[0] - c[5] * center[1]
    for turn, value in ((0.0, mean + half), (0.5 * np.pi, mean - half)):
        ex, ey = np.cos(angle + turn), np.sin(angle + turn)
        m = np.array([0.0, 0.0, 0.0, ex * ex, 2.0 * ex * ey, ey * ey])
        sigma = np.sqrt(max(0.0, m @ (covariance @ m)))
        if value <= max(SIGNIFICANT * sigma, STRAIGHT):
            continue
        low, high = 0.0, 0.0
        for i in range(len(y)):
            for j in range(len(x)):
                if mask[i, j]:
                    t = (x[j] - center[0]) * ex + (y[i] - center[1]) * ey
                    low, high = min(low, t), max(high, t)
        reach = min(high, max(low, (gx * ex + gy * ey) / value))
        out[0] += reach * ex
        out[1] += reach * ey
    return out
