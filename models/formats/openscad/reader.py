"""A `.csg` or `.scad` file as an exact tree: text -> syntax -> shapes -> tree, or one line that says why not."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from models.csg import Csg, Operation, Placed
from models.formats import intake
from models.formats.openscad import syntax
from models.formats.openscad.folder import Folder, decoded
from models.formats.openscad.limits import Budget, Limits
from models.formats.openscad.program import Program
from models.formats.openscad.solids import Solids
from primitives.errors import PalpateError

SUFFIXES = (".csg", ".scad")


@dataclass(frozen=True)
class Drawing:
    """What a file draws [mm]."""

    tree: Csg
    warnings: tuple[str, ...] = ()


def read(path: str | Path, scale: float = 1.0, facets: bool = False, limits: Limits | None = None) -> Drawing:
    """The tree in a file whose unit is worth `scale` mm.

    Circles are round whatever `$fn` says; with `facets` they keep the sides that OpenSCAD gives them.
    """
    file = Path(path)
    if file.is_file() and file.stat().st_size > 4 * syntax.LARGEST:
        raise PalpateError(f"{file.name} is too long for OpenSCAD text; export it as a mesh (STL)")
    text = decoded(intake.read(file), file.name)
    return _drawing(text, file, Folder(file.parent), Solids(facets), scale, limits)


def read_text(
    text: str, name: str = "text", scale: float = 1.0, facets: bool = False, limits: Limits | None = None
) -> Drawing:
    """The tree that a text draws; it may not name other files."""
    return _drawing(text, Path(name), Folder(None), Solids(facets), scale, limits)


def _drawing(
    text: str, file: Path, folder: Folder, solids: Solids, scale: float, limits: Limits | None
) -> Drawing:
    source = syntax.parse(text, file.name)
    budget = Budget(limits or Limits(), place=file.name)
    try:
        with syntax.deep_stack(), np.errstate(all="ignore"):
            program = Program(budget, folder)
            shapes = program.run(source, file)
            alone = [found for shape in shapes if (found := shape.shown_root()) is not None]
            tree = solids.all(alone[:1] or shapes, scale)
    except RecursionError:
        raise budget.error("calls or expressions go too deep; end the recursion or split it up") from None
    if tree is None:
        raise PalpateError(f"{file.name} draws nothing; add a solid, or look for an empty first operand")
    if _depth(tree) > budget.limits.depth:
        deep = f"nests more than {budget.limits.depth} booleans and placements"
        raise PalpateError(f"{file.name} {deep}; draw it flatter")
    return Drawing(tree, tuple(dict.fromkeys([*program.warnings, *solids.warnings])))


def _depth(tree: Csg) -> int:
    """How many nodes stand above the deepest primitive."""
    deepest, left = 0, [(tree, 0)]
    while left:
        node, depth = left.pop()
        deepest = max(deepest, depth)
        if isinstance(node, Operation):
            left += [(child, depth + 1) for child in node.children]
        elif isinstance(node, Placed):
            left.append((node.child, depth + 1))
    return deepest
