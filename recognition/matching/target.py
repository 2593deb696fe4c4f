"""One object as the search reads it: pairs of surface samples by distance, and the distance field.

A pair of samples stands for all pairs of contacts near it.  Pairs are sorted by their distance, so that a window
of distances is a slice; beside each stand the angles of its normals to the line between and to each other, in
steps of 1/255 of a half turn, so that a pair is tested without a root.  The field is kept a second time, coarse:
distance and gradient at each node, 4 bytes together.  All is made in a few milliseconds when first asked for, and
not stored.
"""

from __future__ import annotations

from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numba import njit
from numpy.typing import NDArray

from models.library import Entry
from primitives.arrays import Floats
from recognition.matching.field_kernels import field_at

SAMPLES = 280  # of an object, in the pair index
FULL = 255.0  # steps of a half turn
COARSE = 120.0  # steps of the greatest distance that the coarse field knows, and of a unit vector
_DISTANCES = 256  # bins over which pairs are sorted
_REACH = 0.5  # of the object's size: the greatest distance that the coarse field knows


class Target(NamedTuple):
    """Arrays of one object, in its own frame."""

    points: Floats  # (s, 3) [mm]
    normals: Floats  # (s, 3)
    pairs: NDArray[np.uint16]  # (q, 2) sorted by distance
    angles: NDArray[np.uint8]  # (q, 3) first and second normal to the line from first to second; normals
    starts: NDArray[np.int64]  # (bins + 1,) where each bin of distances begins
    bin: float  # [mm] width of a bin
    values: NDArray[np.int16]  # (i, j, k) of the distance field
    origin: Floats  # (3,) [mm]
    spacing: float  # [mm] of the field
    step: float  # [mm] that one of `values` is worth
    coarse: NDArray[np.int8]  # (i, j, k, 4) distance, gradient
    unit: float  # [mm] that a step of the coarse distance is worth
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


def field_error(target: Target) -> float:
    """[mm] by which the distance field errs beside edges, which linear interpolation rounds off."""
    return 0.3 * target.spacing


def _made(entry: Entry) -> Target:
    samples, field = entry.samples, entry.field
    points = np.array(samples.points[:SAMPLES], dtype=np.float64, order="C")
    normals = np.array(samples.normals[:SAMPLES], dtype=np.float64, order="C")
    low, high = samples.points.min(axis=0), samples.points.max(axis=0)
    size = float(np.linalg.norm(high - low))
    width = max(size, 1e-9) * 1.001 / _DISTANCES
    pairs, angles, starts = _sorted_pairs(points, normals, width, _DISTANCES)
    values, origin = np.asarray(field.values), np.array(field.origin, dtype=np.float64)
    unit = _REACH * size / COARSE
    coarse = _coarse(values, origin, float(field.spacing), float(field.step), unit)
    return Target(
        points, normals, pairs, angles, starts, width, values, origin, float(field.spacing), float(field.step),
        coarse, unit, float(np.sum(samples.area)), np.asarray((low + high) / 2, dtype=np.float64), size,
    )  # fmt: skip


@njit(cache=True, nogil=True)
def _coarse(values, origin, spacing, step, unit):  # type: ignore[no-untyped-def]
    out = np.empty((*values.shape, 4), dtype=np.int8)
    g = np.empty(4)
    for i in range(values.shape[0]):
        for j in range(values.shape[1]):
            for k in range(values.shape[2]):
                x, y, z = origin[0] + i * spacing, origin[1] + j * spacing, origin[2] + k * spacing
                d = field_at(x, y, z, values, origin, spacing, step, g)
                out[i, j, k, 0] = np.int8(min(max(round(d / unit), -COARSE), COARSE))
                for a in range(3):
                    out[i, j, k, 1 + a] = np.int8(round(g[a] * g[3] * COARSE))
    return out


@njit(cache=True, nogil=True)
def _sorted_pairs(points, normals, width, bins):  # type: ignore[no-untyped-def]
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
    pairs, angles = np.empty((k, 2), dtype=np.uint16), np.empty((k, 3), dtype=np.uint8)
    k = 0
    for i in range(n):
        for j in range(i + 1, n):
            at = put[which[k]]
            pairs[at, 0], pairs[at, 1] = i, j
            x, y, z = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
            over = 1.0 / max(np.sqrt(x * x + y * y + z * z), 1e-9)
            a = (normals[i, 0] * x + normals[i, 1] * y + normals[i, 2] * z) * over
            b = (normals[j, 0] * x + normals[j, 1] * y + normals[j, 2] * z) * over
            c = normals[i, 0] * normals[j, 0] + normals[i, 1] * normals[j, 1] + normals[i, 2] * normals[j, 2]
            angles[at, 0], angles[at, 1], angles[at, 2] = steps_of(a), steps_of(b), steps_of(c)
            put[which[k]] += 1
            k += 1
    return pairs, angles, starts


@njit(cache=True, nogil=True, inline="always")
def steps_of(cosine):  # type: ignore[no-untyped-def]
    """An angle in steps, of its cosine."""
    return int(np.arccos(min(max(cosine, -1.0), 1.0)) / np.pi * FULL + 0.5)
