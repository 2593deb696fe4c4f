"""Poses refined on the exact surface, with the curvature of the likelihood there.

Gauss-Newton on the residuals of `facets.likeliest`; a contact counts by how likely it is no outlier, or, for the
absolute distances' sum, by one over its distance, until the curvature is asked: of a sum of n absolute values,
normal ones with sigma = sqrt(pi / 2) b, the least varies by pi sigma^2 / 2 n (Laplace).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from primitives.arrays import Bools, Floats, frozen
from recognition.matching.facets import Facets, bent, likeliest, on_edge, tilt_bound
from recognition.matching.steps import add_bent_normal, add_distance, moved, rotated, solved, turn

_OF_MEDIAN = (2.0 / np.pi) ** 2  # what a distance tells where their sum is least, of Laplace's b, if normal


class Aligned(NamedTuple):
    """Refined poses; per contact the distance and the angle to the point it most likely touched."""

    poses: Floats  # (k, 3, 4) object_from_world
    distances: Floats  # (k, n) [mm]; `beyond` where nothing is near
    angles: Floats  # (k, n) [rad], as chords, to the normal of the surface that facets stand for,
    facet_angles: Floats  # (k, n) [rad] and to that of the facet itself
    information: Floats  # (k, 6, 6) of (v, w) about the contacts' middle, in the object's frame


@njit(cache=True, nogil=True)
def aligned(poses, points, normals, felt, sigma, tau, shares, cap, rounds, wider, absolute, mesh):  # type: ignore[no-untyped-def]
    """Refine each of (k, 3, 4) poses; noise is `wider` times itself at first and as it is at last."""
    count, n = len(poses), len(points)
    poses = poses.copy()
    distances, angles = np.full((count, n), np.inf), np.full((count, n), np.inf)
    facet_angles = np.full((count, n), np.inf)
    information = np.zeros((count, 6, 6))
    stack, reach, found = np.empty(64, dtype=np.int64), np.empty(64), np.empty(7)
    h, b, j, x = np.empty((6, 6)), np.empty(6), np.empty(6), np.empty(6)
    q, m, r, u, center, middle = (np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3),
                                  np.zeros(3))  # fmt: skip
    for i in range(n):
        for k in range(3):
            middle[k] += points[i, k] / n
    least = 1e-3 * n / np.median(sigma) ** 2
    corners, flat, normals_of, sharp, k_of = mesh[0], mesh[1], mesh[2], mesh[6], np.empty((3, 3))
    for row in range(count):
        pose = poses[row]
        step = -1
        while step < rounds:
            step += 1
            wide = 1.0 if step >= rounds - 1 else max(1.0, wider * 0.5**step)
            h[:], b[:] = 0.0, 0.0
            moved(pose, middle, center)
            far = 1.0
            for i in range(n):
                moved(pose, points[i], q)
                rotated(pose, normals[i], m)
                s, a = sigma[i] * wide, tau[i] * min(wide, 3.0)
                cost = likeliest(q, m, felt[i], s, a, cap, mesh, stack, reach, found)
                if not np.isfinite(cost):
                    if step == rounds:
                        distances[row, i], angles[row, i] = np.inf, np.inf
                    continue
                d2, along, turned, beside, touched = 0.0, 0.0, 0.0, 0.0, int(found[6])
                for k in range(3):
                    u[k] = q[k] - found[k]
                    d2 += u[k] * u[k]
                    along += u[k] * found[3 + k]
                    turned += (m[k] - found[3 + k]) ** 2
                    beside += (m[k] - flat[touched, k]) ** 2
                    r[k] = found[k] - center[k]
                d = np.sqrt(d2)
                if step == rounds:
                    distances[row, i], angles[row, i] = d, np.sqrt(turned) if felt[i] else 0.0
                    facet_angles[row, i] = np.sqrt(beside) if felt[i] else 0.0
                weight = shares[i] / (1.0 + np.exp(0.5 * min(d2 / (s * s), 200.0) - 0.35 * cap))
                far = max(far, r[0] * r[0] + r[1] * r[1] + r[2] * r[2])
                on_face = (
                    d < 1e-9 or abs(along) > 0.9 * d or not on_edge(found, corners[touched], sharp[touched])
                )
                for k in range(3):
                    u[k] = found[3 + k] if on_face else u[k] / d
                w = weight / (s * s)
                if absolute:
                    w = _OF_MEDIAN * w if step == rounds else 1.0 / (s * max(d, 0.02 * s))
                add_distance(h, b, r, u, along if on_face else d, w, j)
                if felt[i]:
                    w = (
                        weight
                        / (a * a)
                        / (1.0 + np.exp(0.5 * (min(turned / (a * a), 200.0) - tilt_bound(a))))
                    )
                    bent(corners[touched], normals_of[touched], k_of)
                    add_bent_normal(h, b, m, found[3:6], k_of, r, w, j)
            if step == rounds:
                for p in range(6):
                    for o in range(6):
                        information[row, p, o] = h[max(p, o), min(p, o)]
                break
            for p in range(3):
                h[p, p] += least / (wide * wide)
                h[p + 3, p + 3] += least * far / (wide * wide)
            if not solved(h, b, x):
                continue
            long = x[0] * x[0] + x[1] * x[1] + x[2] * x[2]
            if long > far:
                x *= np.sqrt(far / long)
            turn(pose, x, center)
            turned = x[3] * x[3] + x[4] * x[4] + x[5] * x[5]
            if wide == 1.0 and long + turned * far < 1e-8:
                step = rounds - 1
    return poses, distances, angles, facet_angles, information


def refine(poses: Floats, points: Floats, normals: Floats, felt: Bools, sigma: Floats, tau: Floats,
           shares: Floats, mesh: Facets, wider: float, rounds: int = 12, cap: float = 25.0,
           absolute: bool = False) -> Aligned:  # fmt: skip
    """`aligned`, from Python; `shares` (n,) are what each contact counts for.

    Points may come read-only or not; kernels are compiled for one of them.
    """
    return Aligned(
        *aligned(poses, frozen(points), normals, felt, sigma, tau, shares, cap, rounds, wider, absolute, mesh)
    )
