"""Planes along one axis, and at most two across it, as one prism: a hexagon bar is one primitive, not three.

The sides' lines n . x = d, in order of their normals' angles, meet in the polygon's corners, each with the next;
the polygon is closed where no two normals in a row are half a turn apart or more.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from models.csg import Prism
from primitives.arrays import Floats, frozen
from primitives.shapes import Plane
from recognition.assembly.piece import EXACT, Piece, along, span

_LEAST = 3  # sides
_TURN = 1e-3  # [rad] less than half a turn, at most, between one side and the next


def prism(
    planes: Mapping[int, Plane], hints: Sequence[Floats], corners: Floats
) -> tuple[Piece, tuple[int, ...]] | None:
    """The prism that takes most of the planes, whose normals look out of it, and which it takes; None for none.

    An end that no plane closes reaches past the body's (n, 3) `corners`.
    """
    best: tuple[Piece, tuple[int, ...]] | None = None
    for axis in _axes(planes, hints):
        found = _along_axis(axis, planes, corners)
        if found is not None and (best is None or len(found[1]) > len(best[1])):
            best = found
    return best


def _axes(planes: Mapping[int, Plane], hints: Sequence[Floats]) -> list[Floats]:
    """Directions along which sides may run, each once."""
    normals = [plane.normal for plane in planes.values()]
    crossed = [np.cross(a, b) for i, a in enumerate(normals) for b in normals[i + 1 :]]
    lengths = [float(np.linalg.norm(c)) for c in crossed]
    wanted = [*normals, *hints, *(c / n for c, n in zip(crossed, lengths, strict=True) if n > 0.05)]
    out: list[Floats] = []
    for axis in wanted:
        if all(np.linalg.norm(np.cross(axis, other)) > EXACT for other in out):
            out.append(axis)
    return out


def _along_axis(
    axis: Floats, planes: Mapping[int, Plane], corners: Floats
) -> tuple[Piece, tuple[int, ...]] | None:
    axis = axis if axis[np.argmax(np.abs(axis))] > 0 else -axis
    sides = [i for i, p in planes.items() if abs(float(p.normal @ axis)) < EXACT]
    ends: dict[bool, int] = {}
    for i, plane in planes.items():
        if np.linalg.norm(np.cross(plane.normal, axis)) < EXACT:
            ends.setdefault(bool(plane.normal @ axis > 0), i)
    if len(sides) < _LEAST:
        return None
    below, above = ends.get(False), ends.get(True)
    origin = corners.mean(axis=0)
    caps = [None if k is None else planes[k] for k in (below, above)]
    low, high = span(origin, axis, caps, corners)
    placed = along(origin, axis, low, high)
    outline = _outline([planes[i] for i in sides], placed)
    if outline is None or not high > low:
        return None
    solid = Prism(tuple((float(x), float(y)) for x, y in outline), high - low)
    piece = Piece(
        "prism", "intersect", solid, frozen(placed), None, ((None, None), (None, None), (below, above))
    )
    return piece, tuple(sorted([*sides, *ends.values()]))


def _outline(sides: Sequence[Plane], placed: Floats) -> Floats | None:
    """(k, 2) corners counterclockwise in the prism's own frame; None where the sides leave it open or empty."""
    normals = np.array([plane.normal for plane in sides]) @ placed[:3, :2]
    reach = np.array([float((plane.origin - placed[:3, 3]) @ plane.normal) for plane in sides])
    angle = np.arctan2(normals[:, 1], normals[:, 0])
    order = np.argsort(angle)
    normals, reach, angle = normals[order], reach[order], angle[order]
    gaps = np.diff(np.append(angle, angle[0] + 2 * np.pi))
    if gaps.max() > np.pi - _TURN or gaps.min() < EXACT:
        return None
    following = np.roll(np.arange(len(sides)), -1)
    pairs = np.stack([normals, normals[following]], axis=1)
    found = np.linalg.solve(pairs, np.stack([reach, reach[following]], axis=1)[..., None])[..., 0]
    inside = found @ normals.T - reach
    return found if float(inside.max()) < 1e-6 * float(np.ptp(found, axis=0).max()) else None
