"""A tree as OpenSCAD's flat `.csg` form, which OpenSCAD and FreeCAD open; names stand in comments.

Sizes are the exact ones, in as many digits as give the same number back; `$fn` is chosen so that OpenSCAD's
inscribed polygons stay within `chord` of the circle: r (1 - cos(pi / n)) <= chord.
"""

import os
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from models.csg import (
    Cone,
    Csg,
    Cube,
    Cylinder,
    Difference,
    Intersection,
    Operation,
    Placed,
    Polyhedron,
    Prism,
    Sphere,
    Torus,
)
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
            moved = _block(f"multmatrix({_rows(tree.pose)})", [_lines(tree.child, chord)])
            return [*label, *moved]
        case Operation():
            children = [_lines(child, chord) for child in tree.children]
            return [*label, *_block(f"{_WORDS.get(type(tree), 'union')}()", children)]
    return [*label, *_primitive(tree, chord)]


def _block(head: str, children: Iterable[list[str]]) -> list[str]:
    return [f"{head} {{", *[f"\t{line}" for lines in children for line in lines], "}"]


def _primitive(tree: Csg, chord: float) -> list[str]:
    match tree:
        case Cube():
            return [f"cube(size = {_vector(tree.size)}, center = true);"]
        case Cylinder():
            return [_round(tree.radius, tree.radius, tree.height, chord)]
        case Cone():
            return [_round(tree.bottom_radius, tree.top_radius, tree.height, chord)]
        case Sphere():
            return [f"sphere({_circle(tree.radius, chord)}, r = {_number(tree.radius)});"]
        case Torus():
            return _ring(tree, chord)
        case Prism():
            outline = f"polygon(points = {_rows(tree.outline)}, paths = undef, convexity = 10);"
            pulled = f"height = {_number(tree.height)}, center = true, convexity = 10, scale = [1, 1]"
            return _block(f"linear_extrude({pulled}, $fn = 0, $fa = 12, $fs = 2)", [[outline]])
        case Polyhedron():
            # OpenSCAD wants the corners clockwise, seen from outside
            faces = "[" + ", ".join(_vector(face[::-1]) for face in tree.faces) + "]"
            return [f"polyhedron(points = {_rows(tree.points)}, faces = {faces}, convexity = 10);"]
    raise PalpateError(f"cannot write {tree!r} as OpenSCAD; build it from the primitives of models.csg")


def _round(bottom: float, top: float, height: float, chord: float) -> str:
    sizes = f"h = {_number(height)}, r1 = {_number(bottom)}, r2 = {_number(top)}"
    return f"cylinder({_circle(max(bottom, top), chord)}, {sizes}, center = true);"


def _ring(tree: Torus, chord: float) -> list[str]:
    tube = f"circle({_circle(tree.minor_radius, chord)}, r = {_number(tree.minor_radius)});"
    out = np.eye(4)
    out[0, 3] = tree.major_radius
    around = _circle(tree.major_radius + tree.minor_radius, chord)
    moved = _block(f"multmatrix({_rows(out)})", [[tube]])
    return _block(f"rotate_extrude(angle = 360, convexity = 2, {around})", [moved])


def _circle(radius: float, chord: float) -> str:
    sides = int(np.clip(4 * np.ceil(np.pi / np.sqrt(2 * chord / radius) / 4), 24, 360))
    return f"$fn = {sides}, $fa = 12, $fs = 2"


def _rows(rows: Iterable[Iterable[float]]) -> str:
    return "[" + ", ".join(_vector(row) for row in rows) + "]"


def _vector(values: Iterable[float]) -> str:
    return "[" + ", ".join(_number(float(value)) for value in values) + "]"


def _number(value: float) -> str:
    short = f"{value + 0.0:.12g}"
    return short if float(short) == value else repr(float(value))
