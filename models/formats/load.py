"""A CAD file to the closed triangles of one body in mm: read, scale, close, choose.  The one door to the readers.

Whatever is wrong with a file is one line; whatever was mended is a warning.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from models.formats import intake, mesh, step
from models.formats.labeled import LabeledMesh
from models.formats.repair import RepairConfig, closed
from models.formats.units import MM, SizeLimits, Units, checked_flags, size_warnings
from models.solid import Solid
from primitives.errors import PalpateError


class Parsed(NamedTuple):
    """What a reader found, and in which unit."""

    meshes: list[LabeledMesh]
    mm: float | None  # how many mm the meshes' numbers are worth as the file has it; None: the file is silent
    own: float = 1.0  # how many mm the file's numbers were taken to be worth before the meshes were made


@dataclass(frozen=True, eq=False)
class Loaded:
    """One body of a file."""

    solid: Solid
    name: str
    warnings: tuple[str, ...]


def load(
    path: str | Path,
    units: Units = "auto",
    scale: float = 1.0,
    body: int | None = None,
    limits: SizeLimits | None = None,
) -> Loaded:
    """The solid in a file; `units` is the file's, auto takes the format's own or mm; `body` counts from 1."""
    file = Path(path)
    name, suffix = file.name, file.suffix.lower()
    checked_flags(units, scale)
    if suffix not in READERS and not file.is_dir() and file.exists():
        raise PalpateError(f"cannot read {name}: {suffix or 'no'} extension; use one of {' '.join(READERS)}")
    data = intake.checked(intake.read(file), suffix, name)
    parsed = READERS[suffix](data, name)
    factor = scale * ((parsed.mm or 1.0) if units == "auto" else MM[units] / parsed.own)
    meshes = [_checked(found, name).scaled(factor) for found in parsed.meshes]
    config = RepairConfig(fill_holes=suffix not in step.SUFFIXES)
    warnings: list[str] = []
    solids: list[Solid] = []
    for found in meshes:
        whole, said = closed(found, name, config)
        warnings += said
        solids.append(Solid.from_labeled(whole.vertices, whole.triangles, whole.labels, whole.surfaces))
    solid = solids[0]
    guessed = units == "auto" and parsed.mm is None
    return Loaded(solid, name, (*size_warnings(solid.vertices, name, guessed, limits), *warnings))


def _checked(found: LabeledMesh, name: str) -> LabeledMesh:
    if not len(found.triangles):
        raise PalpateError(f"{name} has no faces; export it as a solid")
    if found.triangles.min() < 0 or found.triangles.max() >= len(found.vertices):
        raise PalpateError(f"{name} has faces with corners that do not exist; export it again")
    if not np.isfinite(found.vertices[np.unique(found.triangles)]).all():
        raise PalpateError(f"{name} has coordinates that are not finite numbers; export it again")
    return found


def _mesh(suffix: str) -> Callable[[bytes, str], Parsed]:
    def read(data: bytes, name: str) -> Parsed:
        vertices, triangles, unit = mesh.parse(data, suffix, name)
        return Parsed([LabeledMesh.of(vertices, triangles)], None if unit is None else MM[unit])

    return read


def _step(data: bytes, name: str) -> Parsed:
    return Parsed(step.parse(data, name), 1.0, step.unit_mm(data))


READERS: dict[str, Callable[[bytes, str], Parsed]] = {
    **dict.fromkeys(step.SUFFIXES, _step),
    **{suffix: _mesh(suffix) for suffix in mesh.SUFFIXES},
}
