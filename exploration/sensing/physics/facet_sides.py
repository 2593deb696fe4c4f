"""The sides of convex facets over the skin: which come near a row, and which cells they cross.

When rows are scanned at poses of their own, sides are picked by where they are at the middle pose, give or take
the most that any part of the skin moves during the scan.
"""

import numpy as np
from numba import njit

from primitives.arrays import Floats, Ints


@njit(cache=True, error_model="numpy")
def most_moved(poses: Floats, middle: Floats, reach: float) -> float:
    """The most that a point within `reach` of the sensor moves between the middle pose and any other."""
    most = 0.0
    for k in (0, len(poses) - 1):
        shift = swing = 0.0
        for i in range(3):
            shift += (poses[k, i, 3] - middle[i, 3]) ** 2
            for j in range(3):
                swing += (poses[k, i, j] - middle[i, j]) ** 2
        most = max(most, np.sqrt(shift) + reach * np.sqrt(swing))
    return most


@njit(cache=True, error_model="numpy")
def see(pose: Floats, loop: Floats, seen: Floats) -> None:
    """Points of the world in the sensor's frame."""
    for i in range(len(loop)):
        dx, dy, dz = loop[i, 0] - pose[0, 3], loop[i, 1] - pose[1, 3], loop[i, 2] - pose[2, 3]
        for k in range(3):
            seen[i, k] = pose[0, k] * dx + pose[1, k] * dy + pose[2, k] * dz


@njit(cache=True, error_model="numpy")
def pick_facets(
    start: Ints, about: Floats, slack: float, x_edges: Floats, y_edges: Floats, near: Ints, spans: Floats
) -> int:
    """List the facets that may touch the skin in `near`, and in `spans` from where to where along y."""
    count = 0
    for f in range(len(start) - 1):
        x_least = y_least = z_least = np.inf
        x_most = y_most = -np.inf
        for i in range(start[f], start[f + 1]):
            x_least, x_most = min(x_least, about[i, 0]), max(x_most, about[i, 0])
            y_least, y_most = min(y_least, about[i, 1]), max(y_most, about[i, 1])
            z_least = min(z_least, about[i, 2])
        beside = x_least > x_edges[-1] + slack or x_most < x_edges[0] - slack
        if not (beside or y_least > y_edges[-1] + slack or y_most < y_edges[0] - slack or z_least > slack):
            near[count], spans[count, 0], spans[count, 1] = f, y_least - slack, y_most + slack
            count += 1
    return count


@njit(cache=True, error_model="numpy")
def pick_sides(
    s0: int, s1: int, about: Floats, slack: float, y_low: float, y_high: float, sides: Ints
) -> int:
    """List the sides of a facet that may come between two rows."""
    count = 0
    for i in range(s0, s1):
        j = i + 1 if i + 1 < s1 else s0
        if min(about[i, 1], about[j, 1]) < y_high + slack and max(about[i, 1], about[j, 1]) > y_low - slack:
            sides[count] = i
            count += 1
    return count


@njit(cache=True, error_model="numpy")
def note_sides(
    s0: int,
    s1: int,
    sides: Ints,
    seen: Floats,
    x_edges: Floats,
    y_edges: Floats,
    first: int,
    last: int,
    left: int,
    right: int,
    head: Ints,
    notes: Ints,
) -> None:
    """Note each side in every cell of the window that it may cross."""
    used = 0
    for i in sides:
        j = i + 1 if i + 1 < s1 else s0
        ax, ay, bx, by = seen[i, 0], seen[i, 1], seen[j, 0], seen[j, 1]
        low, high = min(ay, by), max(ay, by)
        if low >= y_edges[last] or high <= y_edges[first]:
            continue
        if min(ax, bx) >= x_edges[right + 1] or max(ax, bx) <= x_edges[left]:
            continue
        slope = (bx - ax) / (by - ay) if abs(by - ay) > 1e-12 else 0.0
        for r in range(first, last):
            if y_edges[r] >= high or y_edges[r + 1] <= low:
                continue
            p, q = ax, bx
            if slope != 0.0:
                p = ax + slope * (max(low, y_edges[r]) - ay)
                q = ax + slope * (min(high, y_edges[r + 1]) - ay)
            p, q = min(p, q), max(p, q)
            for c in range(left, right + 1):
                if x_edges[c] < q + 1e-9 and x_edges[c + 1] > p - 1e-9 and used < len(notes):
                    notes[used, 0], notes[used, 1] = i, head[r, c]
                    head[r, c] = used
                    used += 1


@njit(cache=True, error_model="numpy")
def span(s0: int, s1: int, sides: Ints, seen: Floats, y: float) -> tuple[float, float]:
    """Where a convex facet begins and ends along the line at y."""
    begins, ends = np.inf, -np.inf
    for i in sides:
        j = i + 1 if i + 1 < s1 else s0
        ay, by = seen[i, 1], seen[j, 1]
        if (ay <= y < by) or (by <= y < ay):
            x = seen[i, 0] + (y - ay) / (by - ay) * (seen[j, 0] - seen[i, 0])
            begins, ends = min(begins, x), max(ends, x)
    return begins, ends
