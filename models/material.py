"""What a simulated object is made of, face by face: how it yields and how rough it is.

    stiffness_n_mm3 = 0.3          # of the whole body; without it the body is rigid
    roughness_mm = 0.02            # root mean square height; without it the body is smooth
    temperature_c = 45.0           # of the whole body; without it that of the air

    [faces.4]                      # as `palpate library show` counts them
    roughness_mm = 0.08

A face yields as a Winkler foundation: pressure over stiffness is how far it gives way.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from math import inf, isfinite
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.boundary import labeled_boundary
from models.solid import Solid
from primitives.arrays import Floats, Ints
from primitives.errors import PalpateError
from primitives.grain import Grain
from primitives.pose import inverse, transform_points
from primitives.surface import RayHits

_NAMES = {"stiffness_n_mm3": "stiffness", "roughness_mm": "roughness"}


@dataclass(frozen=True)
class Material:
    """Of a body or of one face."""

    stiffness: float = inf  # [N/mm^3]
    roughness: float = 0.0  # [mm] root mean square

    def __post_init__(self) -> None:
        if not self.stiffness > 0.0:
            raise PalpateError(f"a stiffness must be a positive number of N/mm^3, not {self.stiffness}")
        if not (isfinite(self.roughness) and self.roughness >= 0.0):
            raise PalpateError(f"a roughness must be 0 mm or more, not {self.roughness}")


RIGID = Material()
AIR = 20.0  # [deg C]


@dataclass(frozen=True)
class Materials:
    """Of a whole body, and of the faces that differ from it."""

    whole: Material = RIGID
    faces: Mapping[int, Material] = field(default_factory=dict)
    grain: float = 1.0  # [mm] over which heights are alike
    temperature: float = AIR  # [deg C]

    def __bool__(self) -> bool:
        special = any(material != RIGID for material in (self.whole, *self.faces.values()))
        return special or self.temperature != AIR

    @staticmethod
    def from_toml(path: Path) -> Materials:
        """See the module."""
        try:
            table = tomllib.loads(path.read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
            reason = (isinstance(error, OSError) and error.strerror) or str(error).splitlines()[0]
            raise PalpateError(f"--material {path} is not a readable TOML file: {reason}") from error
        faces, grain = table.pop("faces", {}), table.pop("grain_mm", 1.0)
        if not isinstance(faces, dict) or not all(isinstance(t, dict) for t in faces.values()):
            raise PalpateError(f"{path}: faces must be tables [faces.ID]")
        if not isinstance(grain, int | float) or not 0.05 <= grain <= 20.0:
            raise PalpateError(f"{path}: grain_mm must be from 0.05 to 20, not {grain!r}")
        temperature = table.pop("temperature_c", AIR)
        if not isinstance(temperature, int | float) or not isfinite(temperature):
            raise PalpateError(f"{path}: temperature_c must be a number, not {temperature!r}")
        whole = _material(table, RIGID, str(path))
        told = {_face_id(key, path): _material(t, whole, f"{path} [faces.{key}]") for key, t in faces.items()}
        return Materials(whole, told, float(grain), float(temperature))


def _face_id(key: str, path: Path) -> int:
    if not key.isdecimal():
        raise PalpateError(f"{path}: [faces.{key}] must be a face's number (palpate library show)")
    return int(key)


def _material(table: Mapping[str, Any], base: Material, where: str) -> Material:
    for key, value in table.items():
        if key not in _NAMES:
            raise PalpateError(f"{where}: unknown key {key!r}; valid keys: {', '.join(_NAMES)}")
        if not isinstance(value, int | float) or isinstance(value, bool):
            raise PalpateError(f"{where}: {key} must be a number, not {value!r}")
    return replace(base, **{_NAMES[key]: float(value) for key, value in table.items()})


@dataclass(frozen=True, eq=False)
class MadeOf:
    """A solid of some material; implements `primitives.surface.TriangleSurface` and `MaterialSurface`."""

    solid: Solid
    materials: Materials
    seed: int = 0  # of the grain

    def __post_init__(self) -> None:
        known = len(self._boundary[0])
        if unknown := [face for face in self.materials.faces if face >= known]:
            raise PalpateError(
                f"no face {unknown[0]}; the part has faces 0 to {known - 1} (palpate library show)"
            )

    def material_of(self, face: int) -> Material:
        """Of one face, as `labeled_boundary` counts them."""
        return self.materials.faces.get(face, self.materials.whole)

    def faces_at(self, points: Floats) -> Ints:
        """(n,) the faces nearest to (n, 3) points."""
        local = transform_points(inverse(self.solid.pose), points)
        return self._boundary[1][self.solid.body.tree.nearest(local).triangle]

    @property
    def uniform(self) -> tuple[float, float] | None:
        """See `MaterialSurface`."""
        whole = self.materials.whole
        return None if self.materials.faces else (whole.stiffness, whole.roughness)

    def materials_at(self, points: Floats) -> tuple[Floats, Floats]:
        """See `MaterialSurface`."""
        if self.uniform is not None:
            stiffness, roughness = self.uniform
            return np.full(len(points), stiffness), np.full(len(points), roughness)
        faces = self.faces_at(points)
        return self._of_face[0][faces], self._of_face[1][faces]

    def grain_at(self, points: Floats) -> Floats:
        """See `MaterialSurface`."""
        return self._grain.at(transform_points(self._part_from_world, points))

    @property
    def temperature(self) -> float:
        """[deg C]."""
        return self.materials.temperature

    @property
    def vertices(self) -> Floats:
        """(v, 3) in the world [mm]."""
        return self.solid.vertices

    @property
    def triangles(self) -> Ints:
        """(t, 3) vertex indices."""
        return self.solid.triangles

    @property
    def neighbors(self) -> Ints:
        """(t, 3) triangle across the edge from corner i to corner i + 1; -1 at an open rim."""
        return self.solid.neighbors

    def signed_distance(self, points: Floats) -> Floats:
        """Of the smooth, unloaded surface."""
        return self.solid.signed_distance(points)

    def normals(self, points: Floats) -> Floats:
        """Of the smooth, unloaded surface."""
        return self.solid.normals(points)

    def cast_rays(self, origins: Floats, directions: Floats) -> RayHits:
        """On the smooth, unloaded surface."""
        return self.solid.cast_rays(origins, directions)

    def first_hits(
        self, origins: NDArray[np.float32], directions: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        """On the smooth, unloaded surface."""
        return self.solid.first_hits(origins, directions)

    @cached_property
    def _boundary(self) -> tuple[tuple[Any, ...], Ints]:
        brep, of_triangle = labeled_boundary(self.solid)
        return brep.faces, of_triangle

    @cached_property
    def _of_face(self) -> tuple[Floats, Floats]:
        each = [self.material_of(i) for i in range(len(self._boundary[0]))]
        stiffness, roughness = (np.array([getattr(m, f.name) for m in each]) for f in fields(Material))
        return stiffness, roughness

    @cached_property
    def _grain(self) -> Grain:
        return Grain(self.materials.grain, self.seed)

    @cached_property
    def _part_from_world(self) -> Floats:
        return inverse(self.solid.pose)
