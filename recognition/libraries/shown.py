"""One model's boundary as `palpate library show` gives it: the JSON, and its page."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Any, cast

from models.boundary import labeled_boundary
from models.brep import Brep
from models.explained import freeform_area_fraction, unassigned_area_fraction
from models.formats.units import Units
from models.freeform_symmetry import symmetry_of_solid
from models.library.build import read_part
from models.library.folder import model_files
from models.library.settings import read_settings
from models.part import Part, load_part
from primitives.errors import PalpateError
from recognition.report.boundary_page import boundary_html
from recognition.report.drawn import drawn
from recognition.report.run_report import ReportMesh

_MARK = b"palpate"  # what every page of ours says in its first lines


@dataclass(frozen=True, eq=False)
class ShownBoundary:
    """A model with its boundary."""

    part: Part
    brep: Brep
    summary: Mapping[str, Any]  # as `--json` prints it


def show(
    name_or_path: str,
    units: str = "auto",
    scale: float = 1.0,
    body: int | None = None,
    facets: bool = False,
) -> ShownBoundary:
    """A built-in part, or a model in a file of any supported format, with its boundary in its own frame."""
    part = load_part(name_or_path, cast(Units, units), scale, body, facets)
    brep, _ = labeled_boundary(part.solid)
    return ShownBoundary(part, brep, _summary(part, brep))


def show_object(folder: Path, name: str, units: str = "auto", scale: float = 1.0) -> ShownBoundary:
    """An object of a library, read from its file as the library's settings say."""
    settings = read_settings(folder, units, scale)
    files = {file.name: file for file in model_files(folder, settings)}
    by_file = {file.path.name: file for file in files.values()}
    found = files.get(name) or by_file.get(name)
    if found is None:
        near = get_close_matches(name, files, n=1, cutoff=0.5) if name else []
        hint = f"; did you mean {near[0]}?" if near else ""
        what = f"no object {name!r} in {folder}{hint}" if name else f"which object of {folder}? give its name"
        raise PalpateError(f"{what} (palpate library list {folder} shows all)")
    part = replace(read_part(found), name=found.name)
    brep, _ = labeled_boundary(part.solid)
    return ShownBoundary(part, brep, _summary(part, brep))


def write_page(shown: ShownBoundary, path: Path) -> None:
    """Write the boundary as one HTML file; it appears whole or not at all, and replaces only a page of ours."""
    _refuse(path)
    html = boundary_html(shown.summary, shown.brep, _mesh(shown.part))
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        partial.write_text(html, encoding="utf-8")
        partial.replace(path)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise PalpateError(f"cannot write {path} ({error.strerror}); choose another folder") from None


def _summary(part: Part, brep: Brep) -> dict[str, Any]:
    solid = part.solid
    return {
        "name": part.name,
        "faces": [face.as_json() for face in brep.faces],
        "edges": [edge.as_json() for edge in brep.edges],
        "volume_mm3": solid.volume,
        "area_mm2": solid.area,
        "extent_mm": solid.extent.tolist(),
        "symmetry": symmetry_of_solid(solid, brep).name,
        "watertight": bool((solid.neighbors >= 0).all()),
        "unassigned_area_fraction": float(unassigned_area_fraction(solid)),
        "freeform_area_fraction": float(freeform_area_fraction(solid)),
        "warnings": [*part.warnings, *brep.check()],
    }


def _mesh(part: Part) -> ReportMesh:
    _, face = labeled_boundary(part.solid)
    return drawn(part.solid, face)


def _refuse(path: Path) -> None:
    if path.suffix.lower() not in (".html", ".htm"):
        raise PalpateError(f"--out {path} is no page; give it a name that ends in .html")
    if path.is_dir():
        raise PalpateError(f"--out {path} is a folder; name a file in it")
    if path.exists() and _MARK not in path.read_bytes()[:4096]:
        raise PalpateError(f"--out {path} is there and no page of Palpate's; choose another name")
