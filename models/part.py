"""A part by name or by file: the one door to what can be explored and recognized."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from models import parts
from models.csg import Csg
from models.formats import mesh
from models.solid import Solid
from primitives.errors import PalpateError


@dataclass(frozen=True, eq=False)
class Part:
    """A solid in its own frame, with what is known about where it came from."""

    name: str
    solid: Solid
    csg: Csg | None  # the tree, where the part was built from one
    warnings: tuple[str, ...] = ()


def load_part(name_or_path: str | Path, units: mesh.Units = "auto", scale: float = 1.0) -> Part:
    """A built-in part, or one in a CAD file; `units` and `scale` are for files."""
    wanted = str(name_or_path)
    if wanted in parts.names():
        tree = parts.build(wanted)
        return Part(wanted, Solid.from_csg(tree), tree)
    if not _looks_like_a_file(wanted):
        raise PalpateError(parts.unknown(wanted))
    loaded = mesh.load(wanted, units, scale)
    try:
        solid = Solid.from_mesh(loaded.vertices, loaded.triangles)
    except PalpateError as error:
        raise PalpateError(f"{Path(wanted).name}: {error}") from None
    return Part(Path(wanted).stem, solid, None, loaded.warnings)


def _looks_like_a_file(text: str) -> bool:
    return bool(Path(text).suffix) or os.sep in text or os.path.lexists(text)
