"""The list of built-in parts: every function of the modules below that returns a tree, in their order."""

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from types import ModuleType

from models.csg import Csg
from models.parts import blocks, brackets, concave, convex, turned
from primitives.errors import PalpateError

_MODULES = (convex, concave, brackets, blocks, turned)


@dataclass(frozen=True)
class BuiltIn:
    """What there is to say about a part without meshing it."""

    name: str
    description: str
    extent: tuple[float, float, float]  # [mm] sides of its bounding box
    convex: bool


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
    low, high = build(name).bounds()
    maker, module = _makers()[name]
    x, y, z = (round(float(side), 6) for side in high - low)
    return BuiltIn(name, (maker.__doc__ or "").rstrip("."), (x, y, z), module is convex)


def unknown(name: str) -> str:
    """The line that says that there is no such part, and what to type instead."""
    near = get_close_matches(name.lower(), names(), n=1, cutoff=0.5)
    hint = f"; did you mean {near[0]}?" if near else ""
    return f"no part {name!r}{hint} (palpate parts lists all)"


@cache
def _makers() -> dict[str, tuple[Callable[[], Csg], ModuleType]]:
    return {
        name: (maker, module)
        for module in _MODULES
        for name, maker in vars(module).items()
        if inspect.isfunction(maker) and maker.__module__ == module.__name__ and name[0] != "_"
    }
