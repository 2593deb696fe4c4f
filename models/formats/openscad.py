"""A tree as OpenSCAD's flat `.csg` form, which OpenSCAD and FreeCAD open; names stand in comments.

Sizes are the exact ones; `$fn` is chosen so that OpenSCAD's inscribed polygons stay within `chord` of the
circle: r (1 - cos(pi / n)) <= chord.
"""

import os
from pathlib import Path

import numpy as np

from models.csg import Cone, Csg, Cube, Cylinder, Difference, Intersection, Operation, Placed, Sphere
from primitives.arrays import Floats
from primitives.errors import PalpateError

_WORDS: dict[type[Operation], str] = {Intersection: "intersection", Difference: "difference"}


def write(tree: Csg, path: str | Path, chord: float = 0.01) -> None:
    """Write a tree to a `.csg` file; the file appears whole or not at all. `chord` is in mm."""
    file = Path(path)
    partial = file.with_name(f".{file.name}.{os.getpid()}.partial")
    try:
        partial.write_text(text(tree, chord), encoding="utf-8")
        partial.replace(file)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise PalpateError(f"cannot write {file} ({error.strerror}); choose another folder") from None


def text(tree: Csg, chord: float = 0.01) -> str:
    """The `.csg` text of a tree, whose circles stay within `chord` [mm]."""
    return "\n".join(_lines(tree, chord)) + "\n"


def _lines(tree: Csg, chord: float) -> list[str]:
    label = [f"// {' '.join(tree.name.split())}"] if tree.name.strip() else []
    match tree:
        case Placed():
            return [*label, *_block(f"multmatrix({_matrix(tree.pose)})", [tree.child], chord)]
        case Operation():
            return [*label, *_block(f"{_WORDS.get(type(tree), 'union')}()", list(tree.children), chord)]
    return [*label, _primitive(tree, chord)]


def _block(head: str, children: list[Csg], chord: float) -> list[str]:
    inner = [f"\t{line}" for child in children for line in _lines(child, chord)]
    return [f"{head} {{", *inner, "}"]


def _primitive(tree: Csg, chord: float) -> str:
    match tree:
        case Cube():
            return f"cube(size = [{', '.join(map(_number, tree.size))}], center = true);"
        case Cylinder():
            return _round(tree.radius, tree.radius, tree.height, chord)
        case Cone():
            return _round(tree.bottom_radius, tree.top_radius, tree.height, chord)
        case Sphere():
            return (
                f"sphere($fn = {_sides(tree.radius, chord)}, $fa = 12, $fs = 2, r = {_number(tree.radius)});"
            )
    raise PalpateError(f"cannot write {tree!r} as OpenSCAD; use Cube, Cylinder, Cone or Sphere")


def _round(bottom: float, top: float, height: float, chord: float) -> str:
    sides = _sides(max(bottom, top), chord)
    sizes = f"h = {_number(height)}, r1 = {_number(bottom)}, r2 = {_number(top)}"
    return f"cylinder($fn = {sides}, $fa = 12, $fs = 2, {sizes}, center = true);"


def _sides(radius: float, chord: float) -> int:
    return int(np.clip(4 * np.ceil(np.pi / np.sqrt(2 * chord / radius) / 4), 24, 360))


def _matrix(moved: Floats) -> str:
    rows = ", ".join(f"[{', '.join(_number(float(x)) for x in row)}]" for row in moved)
    return f"[{rows}]"


def _number(value: float) -> str:
    return f"{value + 0.0:.12g}"
