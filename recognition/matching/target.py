"""One object as the search reads it: pairs of surface samples by distance, and the distance field.

A pair of samples stands for all pairs of contacts near it.  Pairs are sorted by their distance, which is all the
index that the search needs: a window of distances is a slice, and angles are tested within it.  They are made in
a few milliseconds, so they are kept in memory and not in the store.
"""

from __future__ import annotations

from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numba import njit
from numpy.typing import NDArray

from models.library import Entry
from primitives.arrays import Floats

SAMPLES = 280  # of an object, in the pair index
_DISTANCES = 256  # bins over which pairs are sorted


class Target(NamedTuple):
    """Arrays of one object, in its own frame."""

    points: Floats  # (s, 3) [mm]
    normals: Floats  # (s, 3)
    first: NDArray[np.uint16]  # (q,) of each pair, sorted by distance
    second: NDArray[np.uint16]  # (q,)
    starts: NDArray[np.int64]  # (bins + 1,) where each bin of distances begins
    bin: float  # [mm] width of a bin
    values: NDArray[np.int16]  # (i, j, k) of the distance field
    origin: Floats  # (3,) [mm]
    spacing: float  # [mm] of the field
    step: float  # [mm] that one of `values` is worth
    area: float  # [mm^2]
    center: Floats  # (3,) [mm] of the box round the samples
    size: float  # [mm] diagonal of that box


_kept: WeakKeyDictionary[Entry, Target] = WeakKeyDictionary()


def target_of(entry: Entry) -> Target:
    """The arrays of an entry, made once."""
    found = _kept.get(entry)
    if found is None:
        found = _kept[entry] = _made(entry)
    return found


def gap(target: Target) -> float:
    """[mm] between neighboring samples."""
    return float(np.sqrt(target.area / len(target.points)))


def _made(entry: Entry) -> Target:
    samples, field = entry.samples, entry.field
    points = np.array(samples.points[:SAMPLES], dtype=np.float64, order="C")
    normals = np.array(samples.normals[:SAMPLES], dtype=np.float64, order="C")
    low, high = samples.points.min(axis=0), samples.points.max(axis=0)
    size = float(np.linalg.norm(high - low))
    width = max(size, 1e-9) * 1.001 / _DISTANCES
    first, second, starts = _sorted_pairs(points, width, _DISTANCES)
    return Target(
        points, normals, first, second, starts, width,
        np.asarray(field.values), np.array(field.origin, dtype=np.float64), float(field.spacing),
        float(field.step),
        float(np.sum(samples.area)), np.asarray((low + high) / 2, dtype=np.float64), size,
    )  # fmt: skip


@njit(cache=True, nogil=True)
def _sorted_pairs(points, width, bins):  # type: ignore[no-untyped-def]
    n = len(points)
    count = np.zeros(bins + 1, dtype=np.int64)
    which = np.empty(n * (n - 1) // 2, dtype=np.int32)
    k = 0
    for i in range(n):
        for j in range(i + 1, n):
            x, y, z = points[i, 0] - points[j, 0], points[i, 1] - points[j, 1], points[i, 2] - points[j, 2]
            at = min(int(np.sqrt(x * x + y * y + z * z) / width), bins - 1)
            which[k] = at
            count[at + 1] += 1
            k += 1
    starts = np.cumsum(count)
    put = starts.copy()
    first, second = np.empty(k, dtype=np.uint16), np.empty(k, dtype=np.uint16)
    k = 0
    for i in range(n):
        for j in range(i + 1, n):
            at = put[which[k]]
            first[at], second[at] = i, j
            put[which[k]] += 1
            k += 1
    return first, second, starts
