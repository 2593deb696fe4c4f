"""Simple polygons in the plane: clean them, ask whether they cross themselves, measure, triangulate."""

import numpy as np

from models.leaves.distances import segment_distance
from primitives.arrays import Bools, Floats, Ints
from primitives.outlines import signed_area

STRAIGHT = 1e-9  # of the polygon's size: a corner this close to the line of its neighbors is none


def cleaned(outline: Floats) -> Floats:
    """(m, 2) corners counterclockwise, without repeated ones and those on a straight side."""
    tolerance = STRAIGHT * float(np.ptp(outline, axis=0).max(initial=0.0))
    kept = outline
    while len(kept) > 2:
        before, after = np.roll(kept, 1, axis=0), np.roll(kept, -1, axis=0)
        base = after - before
        length = np.linalg.norm(base, axis=1)
        off = np.abs(_cross(base, kept - before)) / np.maximum(length, 1e-300)
        idle = np.where(length > tolerance, off <= tolerance, True)
        idle |= np.linalg.norm(kept - before, axis=1) <= tolerance
        if not idle.any():
            break
        kept = np.delete(kept, int(np.argmax(idle)), axis=0)
    return kept if signed_area(kept) >= 0 else kept[::-1]


def crosses_itself(outline: Floats) -> bool:
    """Whether two sides of (n, 2) corners that are not neighbors meet."""
    n = len(outline)
    ends = np.roll(outline, -1, axis=0)
    size = float(np.ptp(outline, axis=0).max(initial=0.0))
    for i in range(n - 2):
        others = np.arange(i + 2, n - (i == 0))
        if len(others) and _meets(outline[i], ends[i], outline[others], ends[others], 1e-12 * size**2).any():
            return True
    return False


def polygon_distance(points: Floats, outline: Floats) -> Floats:
    """(k,) distance of (k, 2) points from a simple polygon, negative inside."""
    away = np.full(len(points), np.inf)
    inside = np.zeros(len(points), dtype=bool)
    x, y = points.T
    for a, b in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        away = np.minimum(away, segment_distance(points, a, b))
        if a[1] != b[1]:
            spans = (a[1] > y) != (b[1] > y)
            inside ^= spans & (x < a[0] + (y - a[1]) * (b[0] - a[0]) / (b[1] - a[1]))
    return np.where(inside, -away, away)


def triangulated(outline: Floats) -> Ints:
    """(n - 2, 3) counterclockwise triangles of a simple counterclockwise polygon, ear by ear (Meisters 1975).

    Of all ears the one with the widest least angle goes first, so that triangles are not thinner than need be.
    """
    left = list(range(len(outline)))
    out: list[tuple[int, int, int]] = []
    while len(left) > 3:
        corners = outline[left]
        before, after = np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0)
        quality = _least_height(before, corners, after)
        best = np.argsort(-quality, kind="stable").tolist()
        ears = (i for i in best if not _inside_triangle(corners, before[i], corners[i], after[i]).any())
        i = next(ears, best[0])
        out.append((left[i - 1], left[i], left[(i + 1) % len(left)]))
        del left[i]
    out.append((left[0], left[1], left[2]))
    return np.array(out, dtype=np.int64)


def _least_height(a: Floats, b: Floats, c: Floats) -> Floats:
    """(n,) signed height over the longest side of each triangle, negative where it turns right."""
    longest = np.max([np.linalg.norm(q - p, axis=1) for p, q in ((a, b), (b, c), (c, a))], axis=0)
    return np.asarray(_cross(b - a, c - b) / np.maximum(longest, 1e-300))


def _inside_triangle(points: Floats, a: Floats, b: Floats, c: Floats) -> Bools:
    """Whether points lie in a counterclockwise triangle or on its rim, its own corners left out."""
    sides = [_cross(q - p, points - p) for p, q in ((a, b), (b, c), (c, a))]
    own = np.any([(points == corner).all(axis=1) for corner in (a, b, c)], axis=0)
    return np.asarray((np.min(sides, axis=0) >= 0) & ~own)


def _meets(a: Floats, b: Floats, c: Floats, d: Floats, zero: float) -> Bools:
    """Whether segment a to b meets each of the segments c to d."""

    def side(p: Floats, q: Floats, r: Floats) -> Floats:
        value = _cross(q - p, r - p)
        return np.where(np.abs(value) <= zero, 0.0, np.sign(value))

    one, two, three, four = side(a, b, c), side(a, b, d), side(c, d, a), side(c, d, b)
    apart = ((np.minimum(a, b) > np.maximum(c, d)) | (np.minimum(c, d) > np.maximum(a, b))).any(axis=1)
    return np.asarray((one * two <= 0) & (three * four <= 0) & ~apart)


def _cross(a: Floats, b: Floats) -> Floats:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
