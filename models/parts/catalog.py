"""The list of built-in parts: every function of the modules below that returns a tree, in their order."""

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from types import ModuleType

import numpy as np

from models.csg import Csg
from models.parts import blocks, brackets, concave, convex, turned
from primitives.errors import PalpateError

_GROUPS = {
    convex: "Convex",
    concave: "Steps and holes",
    brackets: "Brackets and plates",
    blocks: "Milled blocks",
    turned: "Turned parts and fasteners",
}


@dataclass(frozen=True)
class BuiltIn:
    """What there is to say about a part in a list."""

    name: str
    description: str
    extent: tuple[float, float, float]  # [mm] sides of its bounding box
    convex: bool
    group: str  # what stands over it in a list


def names() -> tuple[str, ...]:
    """The names of all built-in parts, convex ones first."""
    return tuple(_makers())


def build(name: str) -> Csg:
    """The tree of one built-in part."""
    if name not in _makers():
        raise PalpateError(unknown(name))
    return _makers()[name][0]().named(name)


def describe(name: str) -> BuiltIn:
    """Its line in the list of parts."""
    maker, module = _makers()[name]
    return BuiltIn(
        name, (maker.__doc__ or "").rstrip("."), _extent(build(name)), module is convex, _GROUPS[module]
    )


def unknown(name: str) -> str:
    """The line that says that there is no such part, and what to type instead."""
    near = get_close_matches(name.lower(), names(), n=1, cutoff=0.5)
    hint = f"; did you mean {near[0]}?" if near else ""
    return f"no part {name!r}{hint} (palpate parts lists all)"


def _extent(tree: Csg) -> tuple[float, float, float]:
    """Sides of the bounding box [mm], to 0.1: the tree's own box, unless an intersection leaves that too large."""
    low, high = tree.bounds()
    sides = high - low
    if "&" in repr(tree):
        from models.solid import Solid  # only a mesh knows

        sides = np.minimum(sides, Solid.from_csg(tree, tolerance=0.02).extent)
    x, y, z = (round(float(side), 1) for side in sides)
    return x, y, z


@cache
def _makers() -> dict[str, tuple[Callable[[], Csg], ModuleType]]:
    return {
        name: (maker, module)
        for module in _GROUPS
        for name, maker in vars(module).items()
        if inspect.isfunction(maker) and maker.__module__ == module.__name__ and name[0] != "_"
    }
