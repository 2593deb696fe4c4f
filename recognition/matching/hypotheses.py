"""Poses that pairs of contacts allow: an interpretation tree of depth two, then all contacts at once.

Contacts a and b can only lie on surface points i and j whose distance is theirs, and whose normals stand to each
other and to the line between as theirs do (Grimson and Lozano-Perez 1984).  Where both normals are felt such a
pair fixes the pose; without them the object may still turn about the line, and every turn is tried.  Each pose is
scored by all contacts on the object's distance field, and the best that differ from each other are kept.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from primitives.arrays import Floats, Ints
from primitives.evidence import Contacts
from recognition.matching.field_kernels import cost_at, descend
from recognition.matching.target import Target, gap


@dataclass(frozen=True)
class SearchConfig:
    """How far the search goes."""

    pairs: int = 14  # of contacts, with normals
    turned_pairs: int = 3  # of contacts without
    kept: int = 48  # poses of an object, after scoring
    turns: int = 30  # tried about a line
    most: int = 1500  # pairs of samples tried for a pair of contacts without normals
    scored: int = 16  # contacts that score a pose; more are thinned
    angle: float = 0.20  # [rad] by which a normal beside a sample may differ, besides noise
    cap: float = 6.0  # cost beyond which a contact says no more than that it is off
    apart: float = 0.25  # [rad] between poses that are kept; and, times the size, in mm


def search(contacts: Contacts, target: Target, config: SearchConfig, sigma: float) -> tuple[Floats, Floats]:
    """(k, 3, 4) object_from_world and their (k,) costs, best first."""
    felt = contacts.has_normal
    chosen = spread(contacts, config.scored)
    points = np.ascontiguousarray(contacts.points[chosen])
    normals = np.ascontiguousarray(np.where(felt[chosen, None], contacts.normals[chosen], 0.0))
    shown = felt[chosen]
    pairs = telling_pairs(points, normals, shown, config)
    near = gap(target)
    reach = 3.0 * sigma + 0.8 * near
    wide = float(np.hypot(0.7 * near, sigma))
    field = (target.values, target.origin, target.spacing, target.step)
    normal_sigma = float(np.median(contacts.normal_sigma[felt])) if felt.any() else 0.1
    slope = float(np.hypot(config.angle, 2.0 * normal_sigma))
    poses, costs = _searched(
        points, normals, shown, pairs, target.points, target.normals, target.first, target.second, target.starts,
        target.bin, field, reach, slope, wide, config.cap, config.kept, config.turns, config.most, config.apart,
        0.5 * target.size, near,
    )  # fmt: skip
    order = np.argsort(costs, kind="stable")
    return poses[order], costs[order]


def spread(contacts: Contacts, count: int) -> Ints:
    """(m,) rows spread over all: each the farthest from those before, normals counted as distance."""
    n = len(contacts)
    if n <= count:
        return np.arange(n)
    size = float(np.linalg.norm(np.ptp(contacts.points, axis=0))) or 1.0
    where = contacts.points
    if contacts.has_normal.all():
        where = np.hstack([where, 0.25 * size * contacts.normals])
    chosen = [int(np.argmax(np.linalg.norm(where - where.mean(axis=0), axis=1)))]
    away = np.linalg.norm(where - where[chosen[0]], axis=1)
    while len(chosen) < count:
        chosen.append(int(away.argmax()))
        away = np.minimum(away, np.linalg.norm(where - where[chosen[-1]], axis=1))
    return np.array(chosen)


def telling_pairs(points: Floats, normals: Floats, felt: object, config: SearchConfig) -> Ints:
    """(m, 2) pairs of contacts that allow few poses: far apart, their normals across the line and each other."""
    n = len(points)
    a, b = np.triu_indices(n, 1)
    if len(a) == 0:
        return np.empty((0, 2), dtype=np.int64)
    line = points[b] - points[a]
    length = np.linalg.norm(line, axis=1)
    line = line / np.maximum(length, 1e-9)[:, None]
    shown = np.asarray(felt)
    both = shown[a] & shown[b]
    across = np.linalg.norm(np.cross(normals[a], normals[b]), axis=1)
    slant = np.abs(np.einsum("ij,ij->i", normals[a], line)) + np.abs(np.einsum("ij,ij->i", normals[b], line))
    worth = np.where(both, length * (0.15 + across + 0.5 * slant), 0.01 * length)
    many = config.pairs if both.sum() >= 3 else config.turned_pairs
    used = np.zeros(n)
    taken: list[int] = []
    while len(taken) < min(many, len(a)):
        best = int(np.argmax(worth / (1.0 + used[a] + used[b])))
        taken.append(best)
        used[a[best]] += 1
        used[b[best]] += 1
        worth[best] = -1.0
    return np.stack([a[taken], b[taken]], axis=1).astype(np.int64)


@njit(cache=True, nogil=True)
def _searched(  # type: ignore[no-untyped-def]
    points, normals, felt, pairs, sp, sn, first, second, starts, width, field, reach, slope, wide, cap,
    kept, turns, most, apart, radius, near,
):  # fmt: skip
    poses, costs = np.zeros((kept, 3, 4)), np.full(kept, np.inf)
    pose, g, scene, model = np.empty((3, 4)), np.empty(3), np.empty((3, 3)), np.empty((3, 3))
    v = np.empty(3)
    worst = np.inf
    bins = len(starts) - 1
    for row in range(len(pairs)):
        a, b = pairs[row, 0], pairs[row, 1]
        u = points[b] - points[a]
        distance = np.sqrt(_dot(u, u))
        if distance < 1e-6:
            continue
        u = u / distance
        both = felt[a] and felt[b]
        na, nb = normals[a], normals[b]
        tilt = slope + near / max(distance, near)
        between, to_a, to_b = _angle(_dot(na, nb)), _angle(_dot(na, u)), _angle(_dot(nb, u))
        low = starts[min(max(int((distance - reach) / width), 0), bins)]
        high = starts[min(max(int((distance + reach) / width) + 1, 0), bins)]
        turned = 1 if both else turns
        stride = 1 if both else max(1, (high - low) // most)
        if both:
            _frame(u, na, nb, scene)
        else:
            _turned(u, 0.0, scene)
        for at in range(low, high, stride):
            for order in range(2):
                i = first[at] if order == 0 else second[at]
                j = second[at] if order == 0 else first[at]
                v[0], v[1], v[2] = sp[j, 0] - sp[i, 0], sp[j, 1] - sp[i, 1], sp[j, 2] - sp[i, 2]
                length = np.sqrt(_dot(v, v))
                if length < 1e-6 or abs(length - distance) > reach:
                    continue
                v[0], v[1], v[2] = v[0] / length, v[1] / length, v[2] / length
                if felt[a] and abs(_angle(_dot(sn[i], v)) - to_a) > tilt:
                    continue
                if felt[b] and abs(_angle(_dot(sn[j], v)) - to_b) > tilt:
                    continue
                if both:
                    if abs(_angle(_dot(sn[i], sn[j])) - between) > slope:
                        continue
                    _frame(v, sn[i], sn[j], model)
                for turn in range(turned):
                    if not both:
                        _turned(v, 2.0 * np.pi * turn / turns, model)
                    _put(pose, model, scene, points[a], points[b], sp[i], sp[j])
                    cost = cost_at(pose, points, normals, felt, wide, slope, cap, worst, field, g)
                    if cost < worst:
                        _keep(poses, costs, pose, cost, apart, apart * radius, points)
                        worst = costs.max()
    count = 0
    for k in range(kept):
        if np.isfinite(costs[k]):
            poses[count], costs[count] = poses[k], costs[k]
            count += 1
    poses, costs = poses[:count].copy(), costs[:count].copy()
    for k in range(count):
        descend(poses[k], points, normals, felt, wide, slope, cap, 4, field)
        descend(poses[k], points, normals, felt, 0.5 * wide, 0.7 * slope, cap, 4, field)
        costs[k] = cost_at(poses[k], points, normals, felt, 0.35 * wide, 0.7 * slope, cap, 1e9, field, g)
    return poses, costs


@njit(cache=True, nogil=True, inline="always")
def _angle(cosine):  # type: ignore[no-untyped-def]
    return np.arccos(min(max(cosine, -1.0), 1.0))


@njit(cache=True, nogil=True, inline="always")
def _dot(a, b):  # type: ignore[no-untyped-def]
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, nogil=True)
def _frame(u, na, nb, out):  # type: ignore[no-untyped-def]
    """Columns: the line, the part across it of both normals' sum, or of their difference if that is longer."""
    along_a, along_b = _dot(na, u), _dot(nb, u)
    plus, minus = 0.0, 0.0
    for k in range(3):
        x, y = na[k] - along_a * u[k], nb[k] - along_b * u[k]
        out[k, 1], out[k, 2] = x + y, x - y
        plus += (x + y) * (x + y)
        minus += (x - y) * (x - y)
    if max(plus, minus) < 1e-6:
        _turned(u, 0.0, out)
        return
    column, scale = (1, np.sqrt(plus)) if plus >= 0.05 * minus else (2, np.sqrt(minus))
    for k in range(3):
        out[k, 0], out[k, 1] = u[k], out[k, column] / scale
    _across(out)


@njit(cache=True, nogil=True)
def _turned(u, angle, out):  # type: ignore[no-untyped-def]
    """Columns: the line, and two across it, turned about it."""
    least = 0
    for axis in range(1, 3):
        if abs(u[axis]) < abs(u[least]):
            least = axis
    scale = np.sqrt(max(1.0 - u[least] * u[least], 1e-12))
    for k in range(3):
        out[k, 0] = u[k]
        out[k, 1] = ((1.0 if k == least else 0.0) - u[least] * u[k]) / scale
    _across(out)
    c, s = np.cos(angle), np.sin(angle)
    for k in range(3):
        e, f = out[k, 1], out[k, 2]
        out[k, 1], out[k, 2] = c * e + s * f, c * f - s * e


@njit(cache=True, nogil=True, inline="always")
def _across(out):  # type: ignore[no-untyped-def]
    out[0, 2] = out[1, 0] * out[2, 1] - out[2, 0] * out[1, 1]
    out[1, 2] = out[2, 0] * out[0, 1] - out[0, 0] * out[2, 1]
    out[2, 2] = out[0, 0] * out[1, 1] - out[1, 0] * out[0, 1]


@njit(cache=True, nogil=True)
def _put(pose, model, scene, pa, pb, si, sj):  # type: ignore[no-untyped-def]
    for i in range(3):
        shift = 0.5 * (si[i] + sj[i])
        for j in range(3):
            r = model[i, 0] * scene[j, 0] + model[i, 1] * scene[j, 1] + model[i, 2] * scene[j, 2]
            pose[i, j] = r
            shift -= 0.5 * r * (pa[j] + pb[j])
        pose[i, 3] = shift


@njit(cache=True, nogil=True)
def _keep(poses, costs, pose, cost, apart, far, points):  # type: ignore[no-untyped-def]
    """In the place of one like it, if better than that, else of the worst."""
    middle = points[0]
    for k in range(len(costs)):
        if not np.isfinite(costs[k]):
            continue
        trace = 0.0
        for i in range(3):
            for j in range(3):
                trace += poses[k, i, j] * pose[i, j]
        if trace < 1.0 + 2.0 * np.cos(apart):
            continue
        gap2 = 0.0
        for i in range(3):
            x = poses[k, i, 3] - pose[i, 3]
            for j in range(3):
                x += (poses[k, i, j] - pose[i, j]) * middle[j]
            gap2 += x * x
        if gap2 < far * far:
            if cost < costs[k]:
                poses[k], costs[k] = pose, cost
            return
    worst = costs.argmax()
    poses[worst], costs[worst] = pose, cost
