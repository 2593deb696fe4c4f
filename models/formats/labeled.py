"""Triangles as a file gives them, each with the exact surface that it stands for where the file says so."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from models.body import LabeledSurface
from models.formats.weld import renumbered
from primitives.arrays import Floats, Ints, frozen
from primitives.shapes import Cone, Shape


@dataclass(frozen=True, eq=False)
class LabeledMesh:
    """One or more bodies; not yet checked, closed or scaled."""

    vertices: Floats  # (v, 3) in the unit at hand
    triangles: Ints  # (t, 3)
    labels: Ints  # (t,) index into `surfaces`; -1 where the triangle stands for itself
    surfaces: tuple[LabeledSurface, ...] = ()
    name: str = ""

    @staticmethod
    def of(vertices: Floats, triangles: Ints, name: str = "") -> LabeledMesh:
        """Without surfaces."""
        return LabeledMesh(
            frozen(vertices),
            frozen(triangles, np.int64),
            frozen(np.full(len(triangles), -1), np.int64),
            (),
            name,
        )

    def scaled(self, factor: float) -> LabeledMesh:
        """The same, its lengths multiplied."""
        surfaces = tuple(
            s if s.shape is None else s._replace(shape=_scaled(s.shape, factor)) for s in self.surfaces
        )
        return replace(self, vertices=frozen(self.vertices * factor), surfaces=surfaces)

    def with_triangles(self, vertices: Floats, triangles: Ints, source: Ints) -> LabeledMesh:
        """Other triangles, each labeled as the `source` triangle of this mesh that it came from; -1 for none."""
        used, local = renumbered(triangles)
        return replace(
            self,
            vertices=frozen(vertices[used]),
            triangles=frozen(local, np.int64),
            labels=frozen(np.where(source >= 0, self.labels[source], -1), np.int64),
        )


def joined(meshes: list[LabeledMesh]) -> LabeledMesh:
    """All as one."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    firsts = np.cumsum([0, *(len(mesh.surfaces) for mesh in meshes)])
    labels = [np.where(m.labels >= 0, m.labels + first, -1) for m, first in zip(meshes, firsts, strict=False)]
    return LabeledMesh(
        frozen(np.concatenate([mesh.vertices for mesh in meshes])),
        frozen(np.concatenate([m.triangles + s for m, s in zip(meshes, starts, strict=False)]), np.int64),
        frozen(np.concatenate(labels), np.int64),
        tuple(surface for mesh in meshes for surface in mesh.surfaces),
    )


def _scaled(shape: Shape, factor: float) -> Shape:
    sizes = shape.sizes if isinstance(shape, Cone) else tuple(size * factor for size in shape.sizes)
    return shape.with_parts(shape.anchor * factor, shape.direction, sizes)
