"""Surfaces behind meshes as CAD programs make them: rims of unlike counts, long triangles, bends that run on."""

from __future__ import annotations

from collections import Counter
from math import pi

import numpy as np
import pytest

from models.boundary import boundary
from models.brep import Brep
from models.solid import Solid
from primitives.arrays import Floats


def ring(radius: float, z: float, count: int) -> Floats:
    turn = 2 * pi * np.arange(count) / count
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), np.full(count, z)])


def zipped(low: int, high: int, first: int, second: int) -> list[tuple[int, int, int]]:
    """Triangles between a ring of `low` corners from `first` on and one of `high` from `second` on."""
    out, i, j = [], 0, 0
    while i < low or j < high:
        if j == high or (i < low and (i + 1) * high <= (j + 1) * low):
            out.append((first + i, first + (i + 1) % low, second + j % high))
            i += 1
        else:
            out.append((first + i % low, second + (j + 1) % high, second + j))
            j += 1
    return out


def turned(profile: list[tuple[float, float, int]]) -> Brep:
    """The boundary of a turned solid, its rings of (radius, z, corners) from the bottom up."""
    rings = [ring(*row) for row in profile]
    start = np.cumsum([0, *map(len, rings)])
    faces = [(start[0] + 0, start[0] + i + 1, start[0] + i) for i in range(1, len(rings[0]) - 1)]
    for k in range(len(rings) - 1):
        faces += zipped(len(rings[k]), len(rings[k + 1]), int(start[k]), int(start[k + 1]))
    top = int(start[-2])
    faces += [(top, top + i, top + i + 1) for i in range(1, len(rings[-1]) - 1)]
    points = np.concatenate(rings).astype(np.float32).astype(float)
    return boundary(Solid.from_mesh(points, np.array(faces)))


def kinds(brep: Brep) -> dict[str, int]:
    return dict(Counter(face.kind for face in brep.faces))


def test_a_narrow_chamfer_between_rims_of_unlike_counts_is_a_cone() -> None:
    brep = turned([(13, 0, 39), (15, 2, 51), (15, 38, 51), (13, 40, 39)])
    assert brep.check() == ()
    assert kinds(brep) == {"plane": 2, "cylinder": 1, "cone": 2}
    (angle,) = {
        round(float(np.rad2deg(face.shape.sizes[0])), 3) for face in brep.faces if face.kind == "cone"
    }  # type: ignore[union-attr]
    assert angle == pytest.approx(45, abs=0.05)


def test_a_fillet_of_uneven_triangles_is_one_torus() -> None:
    counts = (43, 43, 40, 37, 31, 24)
    angles = zip(np.linspace(pi / 2, 0, 6), counts, strict=True)
    bow = [(17 + 3 * np.sin(a), 27 + 3 * np.cos(a), n) for a, n in angles]
    brep = turned([(20, 0, 43), *bow])
    assert brep.check() == ()
    assert kinds(brep) == {"plane": 2, "cylinder": 1, "torus": 1}


def test_pipes_and_the_bend_between_them_are_told_apart() -> None:
    around, along = 24, 12
    section = 2 * pi * np.arange(around) / around
    out, up = 30 + 8 * np.cos(section), 8 * np.sin(section)
    sweep = np.linspace(0, pi / 2, along + 1)
    bend = [np.column_stack([out * np.cos(a), out * np.sin(a), up]) for a in sweep]
    rings = [bend[0] - [0, 25, 0], *bend, bend[-1] - [25, 0, 0]]
    number = np.arange(around * len(rings)).reshape(len(rings), around)
    a, b = number[:-1], number[1:]
    c, d = np.roll(b, -1, axis=1), np.roll(a, -1, axis=1)
    sides = np.concatenate([np.stack(t, axis=2).reshape(-1, 3) for t in ((a, c, b), (a, d, c))])
    ends = [(number[0, 0], number[0, i + 1], number[0, i]) for i in range(1, around - 1)]
    ends += [(number[-1, 0], number[-1, i], number[-1, i + 1]) for i in range(1, around - 1)]
    brep = boundary(Solid.from_mesh(np.concatenate(rings), np.concatenate([sides, ends])))
    assert brep.check() == ()
    assert kinds(brep) == {"plane": 2, "cylinder": 2, "torus": 1}
