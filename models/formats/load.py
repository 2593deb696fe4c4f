"""A CAD file to the solid of one body in mm: read, scale, close, choose.  The one door to the readers.

Whatever is wrong with a file is one line; whatever was mended is a warning.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from models.formats import gltf, intake, mesh, openscad, step, threemf
from models.formats.bodies import Found, chosen, united, without_splinters
from models.formats.crossings import crossings
from models.formats.facing import seen_from_behind
from models.formats.fair import fair
from models.formats.labeled import LabeledMesh, joined
from models.formats.repair import RepairConfig, closed
from models.formats.units import MM, SizeLimits, Units, checked_flags, size_warnings
from models.formats.weld import renumbered
from models.solid import Solid
from primitives.errors import PalpateError


class Parsed(NamedTuple):
    """What a reader found, and in which unit."""

    meshes: list[LabeledMesh]  # one for each body that the file itself tells apart
    mm: float | None  # how many mm the meshes' numbers are worth as the file has it; None: the file is silent
    own: float = 1.0  # how many mm the file's numbers were taken to be worth before the meshes were made


_BACKS = 0.01  # share of backs among what is seen from outside, from which a solid is inside out
_Reader = Callable[[Path, bytes, step.StepConfig | None], Parsed]


@dataclass(frozen=True, eq=False)
class Loaded:
    """One body of a file."""

    solid: Solid
    warnings: tuple[str, ...]


def load(
    path: str | Path,
    units: Units = "auto",
    scale: float = 1.0,
    body: int | None = None,
    limits: SizeLimits | None = None,
    fineness: step.StepConfig | None = None,
) -> Loaded:
    """The solid in a file; `units` is the file's, auto takes the format's own or mm; `body` counts from 1.

    `fineness` is that of the facets of a STEP file.
    """
    file = Path(path)
    name, suffix = file.name, file.suffix.lower()
    checked_flags(units, scale)
    if suffix not in READERS and not file.is_dir() and file.exists():
        known = " ".join((*READERS, *openscad.SUFFIXES))
        raise PalpateError(f"cannot read {name}: {suffix or 'no'} extension; use one of {known}")
    data = intake.checked(intake.read(file), suffix, name)
    parsed = READERS[suffix](file, data, fineness)
    factor = scale * ((parsed.mm or 1.0) if units == "auto" else MM[units] / parsed.own)
    meshes = [m.scaled(factor) for m in parsed.meshes if len(m.triangles)]
    if not meshes:
        raise PalpateError(f"{name} has no faces; export it as a solid")
    intake.check_triangles(sum(len(m.triangles) for m in meshes), name)
    exact = suffix in step.SUFFIXES
    repair = RepairConfig(fill_holes=not exact)
    found = [_found(m, name, repair) for m in meshes]
    if len(found) > 1 and not any(one.solids for one in found):
        found = [_found(joined(meshes), name, repair)]
    if len(found) == 1 and not exact:
        found = [united(found[0], name)]
    found, thin = without_splinters(found, name)
    picked, number, said = chosen(found, body, name)
    guessed = units == "auto" and parsed.mm is None
    warnings = (
        *size_warnings(picked.solids[number].vertices, name, guessed, limits),
        *thin,
        *said,
        *picked.said,
    )
    if not exact:
        _refuse_crossings(picked.solids[number], name)
    _refuse_inside_out(picked.solids[number], name)
    return Loaded(picked.solids[number], warnings)


def _found(read: LabeledMesh, name: str, config: RepairConfig) -> Found:
    """The solids in one mesh, or why there is none."""
    try:
        if read.triangles.min() < 0 or read.triangles.max() >= len(read.vertices):
            raise PalpateError(f"{name} has faces with corners that do not exist; export it again")
        if not np.isfinite(read.vertices[renumbered(read.triangles)[0]]).all():
            raise PalpateError(f"{name} has coordinates that are not finite numbers; export it again")
        parts, said = closed(read, name, config)
        parts = [fair(part) if part.surfaces else part for part in parts]
        solids = [Solid.from_labeled(p.vertices, p.triangles, p.labels, p.surfaces) for p in parts]
    except PalpateError as error:
        text = str(error)
        return Found(read.name, (), (), text if name in text else f"{name}: {text}")
    return Found(read.name, tuple(solids), tuple(said), "")


def _refuse_crossings(solid: Solid, name: str) -> None:
    points = crossings(solid.vertices, solid.triangles)
    if len(points):
        x, y, z = points[0]
        raise PalpateError(
            f"{name} passes through itself, for example near {x:.4g}, {y:.4g}, {z:.4g} mm; "
            "unite its parts in a mesh editor first"
        )


def _refuse_inside_out(solid: Solid, name: str) -> None:
    if (share := seen_from_behind(solid)) > _BACKS:
        raise PalpateError(
            f"{name} is inside out in places: {share:.0%} of what is seen of it from outside are backs of its "
            "faces; repair it in CAD, or export it as a mesh"
        )


def _mesh(suffix: str) -> _Reader:
    def read(file: Path, data: bytes, _: step.StepConfig | None) -> Parsed:
        return Parsed([LabeledMesh.of(*mesh.parse(data, suffix, file.name))], None)

    return read


def _gltf(file: Path, data: bytes, _: step.StepConfig | None) -> Parsed:
    return Parsed(*gltf.parse(file, data))


def _threemf(file: Path, data: bytes, _: step.StepConfig | None) -> Parsed:
    return Parsed(*threemf.parse(data, file.name))


def _step(file: Path, data: bytes, fineness: step.StepConfig | None) -> Parsed:
    return Parsed(step.parse(data, file.name, fineness), 1.0, step.unit_mm(data))


READERS: dict[str, _Reader] = {
    **{suffix: _mesh(suffix) for suffix in mesh.SUFFIXES},
    **dict.fromkeys(gltf.SUFFIXES, _gltf),
    **dict.fromkeys(threemf.SUFFIXES, _threemf),
    **dict.fromkeys(step.SUFFIXES, _step),
}
