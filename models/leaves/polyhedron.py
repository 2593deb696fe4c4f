"""A solid with flat faces, given by its corners and by the corners round each face."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from models.leaves.expression import Primitive, times
from models.leaves.polygons import triangulated
from primitives.arrays import Floats, Ints, frozen
from primitives.errors import PalpateError
from primitives.pose import frame_along

if TYPE_CHECKING:
    from models.rays.triangle_tree import TriangleTree

FLATNESS = 1e-5  # of the solid's size: how far a face's corners may lie off its plane


@dataclass(frozen=True, repr=False)
class Polyhedron(Primitive):
    """Faces run counterclockwise seen from outside; a solid given the other way round is turned over.

    Points that no face uses are dropped.  Faces that cut through each other are not looked for.
    """

    points: tuple[tuple[float, float, float], ...]  # corners [mm]
    faces: tuple[tuple[int, ...], ...]  # three indices or more each, in order round the face
    name: str = ""

    def __post_init__(self) -> None:
        try:
            corners = np.array(self.points, dtype=float).reshape(len(self.points), 3)
            faces = [tuple(int(i) for i in face) for face in self.faces]
        except (TypeError, ValueError):
            raise PalpateError(
                "a polyhedron needs (x, y, z) points in mm and faces of their indices"
            ) from None
        _refuse_broken(corners, faces)
        used = sorted({i for face in faces for i in face})
        place = {i: k for k, i in enumerate(used)}
        corners, faces = corners[used], [tuple(place[i] for i in face) for face in faces]
        object.__setattr__(self, "points", tuple((float(x), float(y), float(z)) for x, y, z in corners + 0.0))
        volume = _volume(corners, faces)
        if not abs(volume) > 1e-12 * float(np.ptp(corners, axis=0).max()) ** 3:
            raise PalpateError("a polyhedron must hold a volume")
        outward = faces if volume > 0 else [face[::-1] for face in faces]
        object.__setattr__(self, "faces", tuple(_from_least(face) for face in outward))

    def scaled(self, factor: float) -> Polyhedron:
        """Its points; faces are indices."""
        return replace(self, points=times(self.points, factor))

    def support(self, directions: Floats) -> Floats:
        """Of the farthest corner."""
        reach: Floats = (directions @ np.array(self.points).T).max(axis=1)
        return reach

    def signed_distance(self, points: Floats) -> Floats:
        """To the nearest face."""
        return self._tree.signed_distance(points)

    @cached_property
    def normals(self) -> Floats:
        """(f, 3) outward unit normal of each face."""
        corners = np.array(self.points)
        return frozen([_facing(corners[list(face)]) for face in self.faces])

    @cached_property
    def triangles(self) -> tuple[Ints, Ints]:
        """(t, 3) corners, and the (t,) face that each is of."""
        corners = np.array(self.points)
        cut = []
        for face, normal in zip(self.faces, self.normals, strict=True):
            if len(face) == 3:
                cut.append(np.array([face]))
                continue
            flat = (corners[list(face)] - corners[face[0]]) @ frame_along(normal)[:, :2]
            cut.append(np.array(face)[triangulated(flat)])
        of_face = np.repeat(np.arange(len(cut)), [len(piece) for piece in cut])
        return frozen(np.concatenate(cut), np.int64), frozen(of_face, np.int64)

    def __repr__(self) -> str:
        return f"Polyhedron({self.points!r}, {self.faces!r}" + self._label()

    @cached_property
    def _tree(self) -> TriangleTree:
        from models.rays.triangle_tree import TriangleTree  # compiled code, which other primitives do without

        return TriangleTree(np.array(self.points), self.triangles[0])


def _refuse_broken(corners: Floats, faces: list[tuple[int, ...]]) -> None:
    if len(faces) < 4 or len(corners) < 4 or not np.isfinite(corners).all():
        raise PalpateError("a polyhedron needs four finite points and four faces or more")
    for number, face in enumerate(faces):
        if len(face) < 3 or len(set(face)) != len(face):
            raise PalpateError(f"face {number} of a polyhedron needs three different corners or more")
        if min(face) < 0 or max(face) >= len(corners):
            raise PalpateError(f"face {number} of a polyhedron names a point that is not there")
    sides = Counter(pair for face in faces for pair in zip(face, face[1:] + face[:1], strict=True))
    if any(count > 1 or sides[b, a] != 1 for (a, b), count in list(sides.items())):
        raise PalpateError(
            "a polyhedron's faces must close and all run the same way round: each side in two faces, once each way"
        )
    size = float(np.ptp(corners, axis=0).max())
    for number, face in enumerate(faces):
        around = corners[list(face)]
        normal = _facing(around)
        if not normal.any() or float(np.ptp(around @ normal)) > FLATNESS * size:
            raise PalpateError(
                f"face {number} of a polyhedron is not flat or has no area; cut it into triangles"
            )


def _facing(around: Floats) -> Floats:
    """(3,) unit normal of (n, 3) corners that run round a flat polygon (Newell's sum); zero if it has none."""
    total = np.cross(around - around[0], np.roll(around, -1, axis=0) - around[0]).sum(axis=0)
    length = float(np.linalg.norm(total))
    unit: Floats = total / length if length > 0 else np.zeros(3)
    return unit


def _volume(corners: Floats, faces: list[tuple[int, ...]]) -> float:
    local = corners - corners.mean(axis=0)
    fans = [(face[0], b, c) for face in faces for b, c in pairwise(face[1:])]
    a, b, c = np.moveaxis(local[np.array(fans)], 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6


def _from_least(face: tuple[int, ...]) -> tuple[int, ...]:
    start = face.index(min(face))
    return face[start:] + face[:start]
