"""Which contacts, and which pairs of them, a search begins with."""

from __future__ import annotations

import numpy as np

from primitives.arrays import Bools, Floats, Ints
from primitives.evidence import Contacts
from primitives.spread import spread as rows_spread

PARALLEL = 0.35  # [rad] to their mean, within which all normals are those of one face


def of_one_face(normals: Floats, felt: Bools) -> bool:
    """Whether nothing but one flat face was felt, of (n, 3) normals where they were `felt`."""
    if not felt.all():
        return False
    mean = normals.mean(axis=0)
    return bool((normals @ mean > np.cos(PARALLEL) * np.linalg.norm(mean)).all())


def spread(contacts: Contacts, count: int) -> Ints:
    """(m,) rows, each the farthest from those before, normals counted as distance; of no more, all."""
    if len(contacts) <= count:
        return np.arange(len(contacts))
    size = float(np.linalg.norm(np.ptp(contacts.points, axis=0))) or 1.0
    where = contacts.points
    if contacts.has_normal.all():
        where = np.hstack([where, 0.25 * size * contacts.normals])
    return rows_spread(where, count)


def telling_pairs(points: Floats, normals: Floats, felt: Bools, many: int) -> Ints:
    """(m, 2) pairs of contacts that allow few poses: far apart, their normals across the line and each other."""
    n = len(points)
    a, b = np.triu_indices(n, 1)
    if len(a) == 0:
        return np.empty((0, 2), dtype=np.int64)
    line = points[b] - points[a]
    length = np.linalg.norm(line, axis=1)
    line = line / np.maximum(length, 1e-9)[:, None]
    both = felt[a] & felt[b]
    across = np.linalg.norm(np.cross(normals[a], normals[b]), axis=1)
    slant = np.abs(np.einsum("ij,ij->i", normals[a], line)) + np.abs(np.einsum("ij,ij->i", normals[b], line))
    worth = np.where(both, length * (0.15 + across + 0.5 * slant), 0.01 * length)
    used = np.zeros(n)
    taken: list[int] = []
    while len(taken) < min(many, len(a)):
        best = int(np.argmax(worth / (1.0 + used[a] + used[b])))
        taken.append(best)
        used[a[best]] += 1
        used[b[best]] += 1
        worth[best] = -1.0
    return np.stack([a[taken], b[taken]], axis=1).astype(np.int64)
