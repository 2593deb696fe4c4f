"""Holes in a surface filled: the open rim of a missing flat piece becomes triangles again.

A rim is a closed run of edges without a neighbor.  Rims in one plane belong together: one that runs inside
another is its inner rim and is joined to it by a bridge, so that the ring between them is filled and no more.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from models.leaves.polygons import crosses_itself, polygon_distance, triangulated
from primitives.arrays import Floats, Ints
from primitives.outlines import signed_area
from primitives.pose import frame_along


@dataclass(frozen=True)
class HoleConfig:
    """Which holes are filled; lengths are shares of the mesh's longest side."""

    flat: float = 1e-3  # from its plane that a rim may be
    few: int = 4  # edges of a rim that need not be flat
    most: int = 400  # edges of a rim
    holes: int = 200


def filled(vertices: Floats, triangles: Ints, config: HoleConfig | None = None) -> tuple[Ints, int]:
    """(k, 3) triangles that close the holes of a consistently wound mesh, and the number of holes.

    No triangles where one of the holes cannot be closed.
    """
    limits = config or HoleConfig()
    rims, whole = _rims(triangles)
    none = np.empty((0, 3), dtype=np.int64), len(rims)
    if not rims or not whole or len(rims) > limits.holes or any(len(rim) > limits.most for rim in rims):
        return none
    size = float(np.ptp(vertices, axis=0).max())
    planes = [_plane(vertices[rim]) for rim in rims]
    flat = [
        offset <= limits.flat * size or len(rim) <= limits.few
        for rim, (_, _, offset) in zip(rims, planes, strict=True)
    ]
    if not all(flat):
        return none
    out: list[Ints] = []
    for group in _groups(planes, limits.flat * size):
        made = _fill(vertices, [rims[i] for i in group], planes[group[0]][1])
        if made is None:
            return none
        out.append(made)
    return np.concatenate(out), len(rims)


def _rims(triangles: Ints) -> tuple[list[Ints], bool]:
    """Open runs, each in the order in which the missing triangles would have their corners, and if all close.

    One that comes to a dead end begins at an edge that more than two triangles share.
    """
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    top = int(triangles.max()) + 1
    forth, back = ends[:, 0] * top + ends[:, 1], ends[:, 1] * top + ends[:, 0]
    loose = ends[~np.isin(forth, back)][:, ::-1]
    leaving: dict[int, list[int]] = defaultdict(list)
    for a, b in loose.tolist():
        leaving[a].append(b)
    rims, whole = list[Ints](), True
    for first in sorted(leaving):
        while leaving[first]:
            run, at = [first], leaving[first].pop()
            while at != first and leaving[at]:
                run.append(at)
                at = leaving[at].pop()
            whole &= at == first
            rims.append(np.array(run, dtype=np.int64))
    return rims, whole


def _plane(points: Floats) -> tuple[Floats, Floats, float]:
    """Middle, normal (by the rim's own turn) and how far the rim leaves its plane."""
    middle: Floats = points.mean(axis=0)
    after = np.roll(points, -1, axis=0)
    turn = np.cross(points - middle, after - middle).sum(axis=0)
    length = float(np.linalg.norm(turn))
    normal = turn / length if length > 0 else np.array([0.0, 0.0, 1.0])
    return middle, normal, float(np.abs((points - middle) @ normal).max())


def _groups(planes: list[tuple[Floats, Floats, float]], near: float) -> list[list[int]]:
    """Rims that share a plane, whichever way they turn."""
    groups: list[list[int]] = []
    for i, (middle, normal, _) in enumerate(planes):
        for group in groups:
            first, axis, _ = planes[group[0]]
            if abs(abs(float(normal @ axis)) - 1) < 1e-4 and abs(float((middle - first) @ axis)) < near:
                group.append(i)
                break
        else:
            groups.append([i])
    return groups


def _fill(vertices: Floats, rims: list[Ints], normal: Floats) -> Ints | None:
    frame = frame_along(normal)[:, :2]
    made: list[Ints] = []
    outers = [rim for rim in rims if signed_area(vertices[rim] @ frame) > 0]
    if not outers:
        outers, frame = rims, frame[:, ::-1]
    inners = [rim for rim in rims if signed_area(vertices[rim] @ frame) <= 0]
    for outer in outers:
        run = outer
        for inner in inners:
            if polygon_distance(vertices[inner[:1]] @ frame, vertices[outer] @ frame)[0] < 0:
                run = _bridged(vertices, run, inner)
        flat = vertices[run] @ frame
        if len(outer) > 4 and len(run) == len(outer) and crosses_itself(flat):
            return None
        made.append(run[triangulated(flat)])
    return np.concatenate(made)


def _bridged(vertices: Floats, outer: Ints, inner: Ints) -> Ints:
    """One run round both, there and back over the shortest way between them."""
    away = np.linalg.norm(vertices[outer][:, None] - vertices[inner][None], axis=2)
    i, j = np.unravel_index(int(np.argmin(away)), away.shape)
    return np.concatenate([outer[: i + 1], np.roll(inner, -j), inner[j : j + 1], outer[i:]])
