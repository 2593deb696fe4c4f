"""Compiled: every pose that lays a pair of contacts on a pair of samples, scored by all, the best kept.

A pose is object_from_world, a (3, 4) array.  Scores come from the coarse field of `target`.
"""

import numpy as np
from numba import njit

from recognition.matching.field_kernels import cost_at, descend
from recognition.matching.pair_pose import dot, frame, put, turned
from recognition.matching.target import COARSE, FULL, steps_of


@njit(cache=True, nogil=True)
def searched(  # type: ignore[no-untyped-def]
    points, normals, felt, pairs, sp, sn, first, angles, starts, width, coarse, origin, spacing, unit,
    reach, slope, wide, cap, kept, turns, most, apart, radius, near, crowd,
):  # fmt: skip
    """The (k, 3, 4) best poses that differ, and their costs."""
    poses, costs = np.zeros((kept, 3, 4)), np.full(kept, np.inf)
    pose, scene, model = np.empty((3, 4)), np.empty((3, 3)), np.empty((3, 3))
    u, v = np.empty(3), np.empty(3)
    worst, filled = np.inf, 0
    bins = len(starts) - 1
    full = int(FULL)
    flat = int(slope / np.pi * FULL) + 1
    for row in range(len(pairs)):
        a, b = pairs[row, 0], pairs[row, 1]
        for k in range(3):
            u[k] = points[b, k] - points[a, k]
        distance = np.sqrt(dot(u, u))
        if distance < 1e-6:
            continue
        for k in range(3):
            u[k] /= distance
        both = felt[a] and felt[b]
        na, nb = normals[a], normals[b]
        tilt = int((slope + near / max(distance, near)) / np.pi * FULL) + 1
        between, to_a, to_b = steps_of(dot(na, nb)), steps_of(dot(na, u)), steps_of(dot(nb, u))
        low = starts[min(max(int((distance - reach) / width), 0), bins)]
        high = starts[min(max(int((distance + reach) / width) + 1, 0), bins)]
        many = 1 if both else turns
        stride = 1 if both else max(1, (high - low) // most)
        if both:
            frame(u, na, nb, scene)
        else:
            turned(u, 0.0, scene)
        for at in range(low, high, stride):
            fa, fb = int(angles[at, 0]), int(angles[at, 1])
            if both and abs(int(angles[at, 2]) - between) > flat:
                continue
            for order in range(2):
                if order == 0:
                    if (felt[a] and abs(fa - to_a) > tilt) or (felt[b] and abs(fb - to_b) > tilt):
                        continue
                    i, j = first[at, 0], first[at, 1]
                else:
                    if felt[a] and abs(full - fb - to_a) > tilt:
                        continue
                    if felt[b] and abs(full - fa - to_b) > tilt:
                        continue
                    i, j = first[at, 1], first[at, 0]
                for k in range(3):
                    v[k] = sp[j, k] - sp[i, k]
                length = np.sqrt(dot(v, v))
                if length < 1e-6 or abs(length - distance) > reach:
                    continue
                for k in range(3):
                    v[k] /= length
                if both:
                    frame(v, sn[i], sn[j], model)
                for turn in range(many):
                    if not both:
                        turned(v, 2.0 * np.pi * turn / turns, model)
                    put(pose, model, scene, points[a], points[b], sp[i], sp[j])
                    cost = _score(pose, points, normals, felt, wide, slope, cap, worst, coarse, origin, spacing,
                                  unit)  # fmt: skip
                    if cost < worst:
                        filled = _keep(poses, costs, filled, pose, cost, apart, apart * radius, points[0],
                                       normals[0], crowd)  # fmt: skip
                        if filled == kept:
                            worst = costs.max()
    return poses[:filled].copy(), costs[:filled].copy()


@njit(cache=True, nogil=True)
def _score(pose, points, normals, felt, s, a, c, limit, coarse, origin, spacing, unit):  # type: ignore[no-untyped-def]
    """Mean cost of all contacts, or more than `limit` as soon as it must be."""
    total, most = 0.0, limit * len(points)
    over, turn, scale = 1.0 / (s * s), 1.0 / (a * a), 1.0 / COARSE
    nx, ny, nz = coarse.shape[0] - 1, coarse.shape[1] - 1, coarse.shape[2] - 1
    for i in range(len(points)):
        p = points[i]
        x = (pose[0, 0] * p[0] + pose[0, 1] * p[1] + pose[0, 2] * p[2] + pose[0, 3] - origin[0]) / spacing
        y = (pose[1, 0] * p[0] + pose[1, 1] * p[1] + pose[1, 2] * p[2] + pose[1, 3] - origin[1]) / spacing
        z = (pose[2, 0] * p[0] + pose[2, 1] * p[1] + pose[2, 2] * p[2] + pose[2, 3] - origin[2]) / spacing
        qx, qy, qz = min(max(x, 0.0), nx), min(max(y, 0.0), ny), min(max(z, 0.0), nz)
        node = coarse[int(qx + 0.5), int(qy + 0.5), int(qz + 0.5)]
        d = node[0] * unit + spacing * (abs(x - qx) + abs(y - qy) + abs(z - qz))
        total += min(d * d * over, c)
        if felt[i]:
            n = normals[i]
            gx, gy, gz = node[1] * scale, node[2] * scale, node[3] * scale
            sure = np.sqrt(gx * gx + gy * gy + gz * gz)
            along = (
                (pose[0, 0] * n[0] + pose[0, 1] * n[1] + pose[0, 2] * n[2]) * gx
                + (pose[1, 0] * n[0] + pose[1, 1] * n[1] + pose[1, 2] * n[2]) * gy
                + (pose[2, 0] * n[0] + pose[2, 1] * n[1] + pose[2, 2] * n[2]) * gz
            )
            total += min(2.0 * (sure - along) * turn, c * sure)
        if total > most:
            return limit + 1.0
    return total / max(len(points), 1)


@njit(cache=True, nogil=True)
def _keep(poses, costs, filled, pose, cost, apart, far, middle, normal, crowd):  # type: ignore[no-untyped-def]
    """In the place of one like it, if better than that, else of the worst; how many places are filled then.

    Of poses that turn `normal` the same way at most `crowd` are kept: where all contacts lie on one face, the
    poses that slide along one of the object's would fill every place.
    """
    least, alike = 1.0 + 2.0 * np.cos(apart), np.cos(apart)
    many, last = 0, -1
    for k in range(filled):
        trace = 0.0
        for i in range(3):
            for j in range(3):
                trace += poses[k, i, j] * pose[i, j]
        if trace >= least:
            gap2 = 0.0
            for i in range(3):
                x = poses[k, i, 3] - pose[i, 3]
                for j in range(3):
                    x += (poses[k, i, j] - pose[i, j]) * middle[j]
                gap2 += x * x
            if gap2 < far * far:
                if cost < costs[k]:
                    poses[k], costs[k] = pose, cost
                return filled
        if crowd < len(costs):
            along = 0.0
            for i in range(3):
                a, b = 0.0, 0.0
                for j in range(3):
                    a += poses[k, i, j] * normal[j]
                    b += pose[i, j] * normal[j]
                along += a * b
            if along > alike:
                many += 1
                if last < 0 or costs[k] > costs[last]:
                    last = k
    if many >= crowd:
        if cost < costs[last]:
            poses[last], costs[last] = pose, cost
        return filled
    at = filled if filled < len(costs) else costs.argmax()
    if at < filled and cost >= costs[at]:
        return filled
    poses[at], costs[at] = pose, cost
    return min(filled + 1, len(costs))


@njit(cache=True, nogil=True)
def settled(poses, points, normals, felt, wide, slope, cap, rounds, field):  # type: ignore[no-untyped-def]
    """The poses after their descent on the field, in place, as `wide` and `slope` are halved."""
    for k in range(len(poses)):
        descend(poses[k], points, normals, felt, wide, slope, cap, rounds, field)
        descend(poses[k], points, normals, felt, 0.5 * wide, 0.7 * slope, cap, rounds, field)


@njit(cache=True, nogil=True)
def weighed(poses, points, normals, felt, wide, slope, cap, field):  # type: ignore[no-untyped-def]
    """(k,) mean costs of poses on the field."""
    costs, g = np.empty(len(poses)), np.empty(4)
    for k in range(len(poses)):
        costs[k] = cost_at(poses[k], points, normals, felt, wide, slope, cap, 1e9, field, g)
    return costs


@njit(cache=True, nogil=True)
def distinct(poses, costs, most, apart, far, middle, normal, crowd):  # type: ignore[no-untyped-def]
    """The (k, 3, 4) best poses, each only once, best first, and their costs; `crowd` as they are kept."""
    kept, least = np.full((most, 3, 4), 0.0), np.full(most, np.inf)
    filled = 0
    for k in np.argsort(costs):
        if filled == most:
            break
        filled = _keep(kept, least, filled, poses[k], costs[k], apart, far, middle, normal, crowd)
    return kept[:filled].copy(), least[:filled].copy()
