"""Poses refined on the exact surface, with the curvature of the likelihood there.

Gauss-Newton on the residuals of `facets.likeliest`; a contact counts by how likely it is no outlier, or, for the
absolute distances' sum, by one over its distance.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from primitives.arrays import Floats
from recognition.matching.facets import Facets, likeliest, tilt_bound
from recognition.matching.field_kernels import turn


class Aligned(NamedTuple):
    """Refined poses; per contact the distance and the angle to the point it most likely touched."""

    poses: Floats  # (k, 3, 4) object_from_world
    distances: Floats  # (k, n) [mm]; `beyond` where nothing is near
    angles: Floats  # (k, n) [rad], as chords
    information: Floats  # (k, 6, 6) of (v, w) about the contacts' middle, in the object's frame


@njit(cache=True, nogil=True)
def aligned(poses, points, normals, felt, sigma, tau, cap, rounds, wider, absolute, mesh):  # type: ignore[no-untyped-def]
    """Refine each of (k, 3, 4) poses; noise is `wider` times itself at first and as it is at last."""
    k, n = len(poses), len(points)
    poses = poses.copy()
    distances, angles = np.full((k, n), np.inf), np.full((k, n), np.inf)
    information = np.zeros((k, 6, 6))
    stack, reach, found = np.empty(64, dtype=np.int64), np.empty(64), np.empty(6)
    jd, jn = np.empty(6), np.empty((3, 6))
    middle = np.zeros(3)
    for i in range(n):
        middle += points[i] / n
    for row in range(k):
        pose = poses[row]
        for step in range(rounds + 1):
            wide = max(1.0, wider * 0.5**step)
            if step >= rounds - 1:
                wide = 1.0
            h, b = np.zeros((6, 6)), np.zeros(6)
            center = pose[:, :3] @ middle + pose[:, 3]
            far = 1.0
            for i in range(n):
                q = pose[:, :3] @ points[i] + pose[:, 3]
                m = pose[:, :3] @ normals[i]
                s, a = sigma[i] * wide, tau[i] * min(wide, 3.0)
                cost = likeliest(q, m, felt[i], s, a, cap, mesh, stack, reach, found)
                if not np.isfinite(cost):
                    if step == rounds:
                        distances[row, i], angles[row, i] = np.inf, np.inf
                    continue
                e = q - found[:3]
                d = np.sqrt(e @ e)
                along = e @ found[3:]
                u = found[3:].copy() if d < 1e-9 or abs(along) > 0.9 * d else e / d
                if step == rounds:
                    x = m - found[3:]
                    distances[row, i], angles[row, i] = d, np.sqrt(x @ x) if felt[i] else 0.0
                weight = 1.0 / (1.0 + np.exp(0.5 * min(d * d / (s * s), 200.0) - 0.35 * cap))
                r = q - center
                far = max(far, r @ r)
                jd[:3] = u
                jd[3], jd[4], jd[5] = (
                    r[1] * u[2] - r[2] * u[1],
                    r[2] * u[0] - r[0] * u[2],
                    r[0] * u[1] - r[1] * u[0],
                )
                w = 1.0 / (s * max(d, 0.02 * s)) if absolute else weight / (s * s)
                for p in range(6):
                    b[p] -= w * (e @ u) * jd[p]
                    for o in range(6):
                        h[p, o] += w * jd[p] * jd[o]
                if felt[i]:
                    x = m - found[3:]
                    turned = min((x @ x) / (a * a), 200.0)
                    w = weight / (a * a) / (1.0 + np.exp(0.5 * (turned - tilt_bound(a))))
                    jn[:] = 0.0
                    jn[0, 4], jn[0, 5], jn[1, 3] = m[2], -m[1], -m[2]
                    jn[1, 5], jn[2, 3], jn[2, 4] = m[0], m[1], -m[0]
                    h += w * (jn.T @ jn)
                    b -= w * (jn.T @ x)
            if step == rounds:
                information[row] = h
                break
            least = 1e-3 * n / (np.median(sigma) ** 2 * wide * wide)
            for p in range(3):
                h[p, p] += least
                h[p + 3, p + 3] += least * far
            x = np.linalg.solve(h, b)
            long = np.sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])
            if long > np.sqrt(far):
                x *= np.sqrt(far) / long
            turn(pose, x, center)
    return poses, distances, angles, information


def refine(poses: Floats, points: Floats, normals: Floats, felt: object, sigma: Floats, tau: Floats,
           mesh: Facets, wider: float, rounds: int = 12, cap: float = 25.0,
           absolute: bool = False) -> Aligned:  # fmt: skip
    """`aligned`, from Python."""
    return Aligned(*aligned(poses, points, normals, felt, sigma, tau, cap, rounds, wider, absolute, mesh))
