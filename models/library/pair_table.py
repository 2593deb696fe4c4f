"""How probable the distance and angles of two places on an object are: what tells objects apart before any pose.

Two surface points at a distance d have three angles that no motion changes: of each normal to the line between,
and between the normals (Drost et al. 2010 have the feature).  For every object the histogram of

    log p(d, two angles | angle between the normals)

over random pairs of its surface is kept, in steps of a byte: the condition takes out that one side of an object
shows no opposite normals (our derivation).  Distances are binned by their logarithm, angles about 0, 30, ... 180
degrees, so that the angles of machined parts are middles of bins.  Where a normal is lacking the histogram of d
alone serves.  Of a whole library this is one table, a row a bin: the score of every object is a sum of rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from models.library.samples import SurfaceSamples
from primitives.arrays import Bools, Floats

SHORTEST = 2.0  # [mm] all below is one bin
RATIO = 1.15  # from one bin of distances to the next
DISTANCES = 45  # bins: up to a meter
ANGLES = 7  # bins of a half turn
FEATURES = DISTANCES * ANGLES * ANGLES * (ANGLES + 1) // 2
BINS = FEATURES + DISTANCES
LEAST = 1e-7  # probability of what was never seen
_SPAN = -np.log(LEAST)
_COUNT = 400  # samples that are paired at once
_BLUR = 0.3, 0.037  # [mm], [rad] of a sensor's noise, so that edges of bins are soft


class PairTable(NamedTuple):
    """Of all objects of a library."""

    names: tuple[str, ...]
    scores: NDArray[np.uint8]  # (BINS, m), each 0 to 255 for a log probability of -_SPAN to 0

    def rank(self, points: Floats, normals: Floats, felt: Bools) -> Floats:
        """(m,) mean log probability of all pairs of contacts under each object."""
        bins = pair_bins(points, normals, felt)
        if not len(bins):
            return np.zeros(len(self.names))
        rows, times = np.unique(bins, return_counts=True)
        mean = _summed(self.scores, rows, times) / (255.0 * len(bins))
        return np.asarray(_SPAN * (mean - 1.0))


def pair_scores(samples: SurfaceSamples) -> NDArray[np.uint8]:
    """(BINS,) of one object."""
    rng = np.random.default_rng(0)
    counts = np.zeros(BINS)
    for first in range(0, min(len(samples), 2 * _COUNT), _COUNT):
        rows = slice(first, first + _COUNT)
        points = samples.points[rows] + _BLUR[0] * rng.standard_normal(samples.points[rows].shape)
        normals = samples.normals[rows] + _BLUR[1] * rng.standard_normal(points.shape)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        bins = pair_bins(points, normals, np.ones(len(points), dtype=bool))
        counts[:FEATURES] += np.bincount(bins, minlength=FEATURES)
    share = counts[:FEATURES] / max(counts.sum(), 1.0)
    shared = share.reshape(-1, ANGLES)
    counts[:FEATURES] = ((shared + LEAST) / (shared.sum(axis=0) + 1e-3)).ravel()
    counts[FEATURES:] = share.reshape(DISTANCES, -1).sum(axis=1)
    log = np.log(np.clip(counts, LEAST, 1.0))
    return np.asarray(np.rint((log + _SPAN) / _SPAN * 255.0).astype(np.uint8))


def table_of(names: Sequence[str], scores: Sequence[NDArray[np.uint8]]) -> PairTable:
    """One table of many objects."""
    if not names:
        return PairTable((), np.empty((BINS, 0), dtype=np.uint8))
    return PairTable(tuple(names), np.ascontiguousarray(np.stack(scores, axis=1)))


@njit(cache=True, nogil=True)
def pair_bins(points, normals, felt):  # type: ignore[no-untyped-def]
    """(n (n - 1) / 2,) the bin of each pair."""
    n = len(points)
    out = np.empty(n * (n - 1) // 2, dtype=np.int32)
    u = np.empty(3)
    at = 0
    scale = (ANGLES - 1) / np.pi
    for i in range(n):
        for j in range(i + 1, n):
            d2 = 0.0
            for k in range(3):
                u[k] = points[j, k] - points[i, k]
                d2 += u[k] * u[k]
            d = max(np.sqrt(d2), 1e-9)
            row = (
                min(max(int(np.log(d / SHORTEST) / np.log(RATIO)) + 1, 0), DISTANCES - 1)
                if d > SHORTEST
                else 0
            )
            if not (felt[i] and felt[j]):
                out[at] = FEATURES + row
                at += 1
                continue
            a, b, c = 0.0, 0.0, 0.0
            for k in range(3):
                a += normals[i, k] * u[k] / d
                b -= normals[j, k] * u[k] / d
                c += normals[i, k] * normals[j, k]
            x = int(np.arccos(min(max(a, -1.0), 1.0)) * scale + 0.5)
            y = int(np.arccos(min(max(b, -1.0), 1.0)) * scale + 0.5)
            z = int(np.arccos(min(max(c, -1.0), 1.0)) * scale + 0.5)
            low, high = min(x, y), max(x, y)
            both = high * (high + 1) // 2 + low
            out[at] = (row * (ANGLES * (ANGLES + 1) // 2) + both) * ANGLES + z
            at += 1
    return out


@njit(cache=True, nogil=True)
def _summed(scores, rows, times):  # type: ignore[no-untyped-def]
    out = np.zeros(scores.shape[1], dtype=np.int64)
    for k in range(len(rows)):
        row, many = rows[k], times[k]
        for m in range(scores.shape[1]):
            out[m] += many * scores[row, m]
    return out
