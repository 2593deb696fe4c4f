"""Outlines in a plane: rims traced round a mask, corners left out that lie almost on a line, places inside."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from primitives.arrays import Bools, Floats


def traced(mask: Bools) -> list[Floats]:
    """Closed rims of a (rows, columns) mask as (n, 2) corners x, y between pixels, the mask on one side all along.

    Where two pixels touch at a corner only, the rims pass it apart.
    """
    padded = np.pad(mask, 1)
    leaving: dict[tuple[int, int], list[tuple[int, int]]] = defaultdict(list)
    for (dy, dx), (start, end) in _SIDES.items():
        outer = np.roll(padded, (-dy, -dx), axis=(0, 1))
        for y, x in np.argwhere(padded & ~outer).tolist():
            leaving[x - 1 + start[0], y - 1 + start[1]].append((x - 1 + end[0], y - 1 + end[1]))
    rims = []
    for first in list(leaving):
        while leaving[first]:
            rim, at = [first], leaving[first].pop()
            while at != first:
                rim.append(at)
                at = _next(rim[-2], at, leaving[at])
            rims.append(np.array(rim, dtype=float))
    return rims


def simplified(points: Floats, tolerance: float) -> Floats:
    """Of (n, 2) points along a line those that keep it within `tolerance` (Douglas and Peucker 1973)."""
    kept = np.zeros(len(points), dtype=bool)
    kept[[0, -1]] = True
    stack = [(0, len(points) - 1)]
    while stack:
        first, last = stack.pop()
        if last - first < 2:
            continue
        along, inner = points[last] - points[first], points[first + 1 : last] - points[first]
        length = float(np.hypot(*along))
        if length > 0:
            off = np.abs(inner[:, 0] * along[1] - inner[:, 1] * along[0]) / length
        else:
            off = np.hypot(inner[:, 0], inner[:, 1])
        farthest = int(np.argmax(off))
        if off[farthest] > tolerance:
            middle = first + 1 + farthest
            kept[middle] = True
            stack += [(first, middle), (middle, last)]
    return points[kept]


def signed_area(outline: Floats) -> float:
    """Of (n, 2) corners, positive where they run counterclockwise (the shoelace formula)."""
    after = np.roll(outline, -1, axis=0)
    return float(outline[:, 0] @ after[:, 1] - outline[:, 1] @ after[:, 0]) / 2


def depth_inside(rims: Sequence[Floats], places: Floats) -> Floats:
    """(n,) how far (n, 2) places lie inside an odd number of closed rims of (m, 2) corners; negative outside.

    That is the distance to the nearest rim; without rims all lie outside, without end.
    """
    away, inside = np.full(len(places), np.inf), np.zeros(len(places), dtype=bool)
    x, y = places.T
    for rim in rims:
        for a, b in zip(rim, np.roll(rim, -1, axis=0), strict=True):
            along = b - a
            share = np.clip((places - a) @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
            away = np.minimum(away, np.linalg.norm(places - a - share[:, None] * along, axis=1))
            if a[1] != b[1]:
                spans = (a[1] > y) != (b[1] > y)
                inside ^= spans & (x < a[0] + (y - a[1]) * (b[0] - a[0]) / (b[1] - a[1]))
    return np.where(inside, away, -away)


_SIDES = {  # towards the neighbor: from and to which corner of the pixel the rim runs
    (-1, 0): ((0, 0), (1, 0)),
    (0, 1): ((1, 0), (1, 1)),
    (1, 0): ((1, 1), (0, 1)),
    (0, -1): ((0, 1), (0, 0)),
}


def _next(before: tuple[int, int], at: tuple[int, int], ways: list[tuple[int, int]]) -> tuple[int, int]:
    """Of the ways on from a corner the one that turns right, towards the pixel that the rim goes round."""
    dx, dy = at[0] - before[0], at[1] - before[1]
    ways.sort(key=lambda way: dx * (way[1] - at[1]) - dy * (way[0] - at[0]))
    return ways.pop()
