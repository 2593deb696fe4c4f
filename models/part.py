"""A part by name or by file: the one door to what can be explored and recognized."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from models import parts
from models.csg import Csg
from models.formats import intake, openscad
from models.formats.drawn import body_of
from models.formats.load import load
from models.formats.units import MM, Units, checked_flags, size_warnings
from models.solid import Solid
from primitives.errors import PalpateError


@dataclass(frozen=True, eq=False)
class Part:
    """A solid in its own frame, with what is known about where it came from."""

    name: str
    solid: Solid
    csg: Csg | None  # the tree, where the part was built from one
    warnings: tuple[str, ...] = ()


def load_part(
    name_or_path: str | Path,
    units: Units = "auto",
    scale: float = 1.0,
    body: int | None = None,
    facets: bool = False,
) -> Part:
    """A built-in part, or one in a CAD file; `units` and `body` (from 1) are for files.

    `facets` keeps the flat sides that OpenSCAD gives its circles, which are round else.
    """
    wanted = str(name_or_path)
    if wanted in parts.names():
        _require_only_body(wanted, body)
        checked_flags(units, scale)
        tree = parts.build(wanted) if scale == 1.0 else parts.build(wanted).scaled(scale)
        return Part(wanted, Solid.from_csg(tree), tree)
    if not (intake.looks_like_a_file(wanted) or os.path.lexists(wanted)):
        raise PalpateError(parts.unknown(wanted))
    if Path(wanted).suffix.lower() in openscad.SUFFIXES:
        return _drawn(Path(wanted), units, scale, body, facets)
    loaded = load(wanted, units, scale, body)
    return Part(Path(wanted).stem, loaded.solid, None, loaded.warnings)


def _drawn(file: Path, units: Units, scale: float, body: int | None, facets: bool) -> Part:
    """A part whose file says what it is built from."""
    checked_flags(units, scale)
    drawing = openscad.read(file, scale * MM.get(units, 1.0), facets)
    size_warnings(drawing.tree.bounds(), file.name, units == "auto")  # refuses what is too large to mesh
    drawn = body_of(drawing.tree, body, file.name)
    said = size_warnings(drawn.solid.vertices, file.name, units == "auto")
    return Part(file.stem, drawn.solid, drawn.tree, (*said, *drawing.warnings))


def _require_only_body(name: str, body: int | None) -> None:
    if body not in (None, 1):
        raise PalpateError(f"{name} has no body {body}; it holds one body")
