"""Solids with flat sides: circles with the sides that OpenSCAD gives them, and the corners of any."""

from __future__ import annotations

import numpy as np

from models.csg import Csg, Cube, Polyhedron, Prism
from models.formats.openscad.functions import cosine, sine
from primitives.arrays import Floats

Face = tuple[int, ...]


def polygon(count: int, radius: float) -> Floats:
    """(count, 2) corners of OpenSCAD's circle, the first on the x axis."""
    turns = [360.0 * i / count for i in range(count)]
    return radius * np.array([(cosine(turn), sine(turn)) for turn in turns])


def bar(count: int, low: float, high: float, height: float, label: str) -> Csg:
    """A cylinder or cone with flat sides, centered."""
    if low == high:
        return Prism(tuple(map(tuple, polygon(count, low).tolist())), height, label)
    return turned(
        np.array([(0.0, -height / 2), (low, -height / 2), (high, height / 2), (0.0, height / 2)]),
        count,
        label,
    )


def ball(count: int, radius: float, label: str) -> Csg:
    """OpenSCAD's sphere: rings of corners, none of them at the poles."""
    rings = (count + 1) // 2
    tilts = [180.0 * (i + 0.5) / rings for i in reversed(range(rings))]
    profile = [(radius * sine(tilt), radius * cosine(tilt)) for tilt in tilts]
    return turned(np.array([(0.0, profile[0][1]), *profile, (0.0, profile[-1][1])]), count, label)


def turned(profile: Floats, count: int, label: str) -> Csg:
    """(n, 2) counterclockwise corners with x >= 0, copied round the z axis and joined by flat sides."""
    kept = [row for i, row in enumerate(profile.tolist()) if row != profile[i - 1].tolist()]
    circle = polygon(count, 1.0)
    corners: list[tuple[float, float, float]] = []
    rings: list[list[int]] = []
    for x, z in kept:
        start = len(corners)
        around = [(x * c, x * s, z) for c, s in circle.tolist()] if x > 0 else [(0.0, 0.0, z)]
        corners += around
        rings.append([start + i % len(around) for i in range(count)])
    faces: list[Face] = []
    for k, (lower, upper) in enumerate(zip(rings, rings[1:] + rings[:1], strict=True)):
        low, high = kept[k], kept[(k + 1) % len(kept)]
        if low[0] == high[0] == 0:
            continue
        if low[1] == high[1] and 0 in (low[0], high[0]):
            faces.append(tuple(lower) if low[0] else tuple(upper[::-1]))
            continue
        for i in range(count):
            j = (i + 1) % count
            side = dict.fromkeys((lower[i], lower[j], upper[j], upper[i]))
            faces.append(tuple(side))
    return Polyhedron(tuple(corners), tuple(faces), label)


def outside(primitive: Cube | Prism | Polyhedron) -> tuple[Floats, tuple[Face, ...]]:
    """(n, 3) corners, and those round each face."""
    if isinstance(primitive, Polyhedron):
        return np.array(primitive.points), primitive.faces
    if isinstance(primitive, Cube):
        x, y, half = primitive.size[0] / 2, primitive.size[1] / 2, primitive.size[2] / 2
        outline = np.array([(-x, -y), (x, -y), (x, y), (-x, y)])
    else:
        outline, half = np.array(primitive.outline), primitive.height / 2
    n = len(outline)
    ends = [np.column_stack([outline, np.full(n, z)]) for z in (-half, half)]
    around = [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)]
    return np.concatenate(ends), (tuple(range(n))[::-1], tuple(range(n, 2 * n)), *around)
