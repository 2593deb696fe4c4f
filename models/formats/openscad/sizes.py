"""The sizes that OpenSCAD's primitives are given, with OpenSCAD's defaults, or one line that names the line."""

from __future__ import annotations

import math

import numpy as np

from models.formats.openscad.shapes import Shape
from models.formats.openscad.values import Value, is_number, true
from primitives.arrays import Floats

MOST_POINTS = {2: 2000, 3: 20_000}  # of a polygon; of a polyhedron, which may be a mesh


def number(shape: Shape, name: str, default: float) -> float:
    """One finite number."""
    value = shape.arguments.get(name)
    if value is None:
        if name in shape.arguments:
            raise shape.error(f"{shape.name}'s {name} is undefined; give a number")
        return default
    if not is_number(value) or not math.isfinite(value):
        raise shape.error(f"{shape.name}'s {name} must be a finite number; check it")
    return float(value)


def length(shape: Shape, name: str, default: float) -> float:
    """A positive number."""
    value = number(shape, name, default)
    if not value > 0:
        raise shape.error(f"{shape.name}'s {name} must be greater than zero, not {value:g}")
    return value


def radius(shape: Shape, end: str = "", zero: bool = False) -> float:
    """A radius, given as such or as a diameter; `end` is 1 or 2 for a cylinder's ends."""
    given = shape.arguments
    for name, share in ((f"d{end}", 0.5), (f"r{end}", 1.0), ("d", 0.5), ("r", 1.0)):
        if given.get(name) is not None:
            value = number(shape, name, 1.0) * share
            if value < 0 or (value == 0 and not zero):
                raise shape.error(f"{shape.name}'s {name} must be greater than zero, not {value / share:g}")
            return value
    if any(name in given for name in (f"d{end}", f"r{end}")) and not end:
        raise shape.error(f"{shape.name}'s radius is undefined; give a number")
    return 1.0


def sides(shape: Shape, count: int) -> Floats:
    """(count,) lengths from `size`, which may be one for all."""
    value = shape.arguments.get("size", 1.0)
    if is_number(value):
        value = (value,) * count
    if not isinstance(value, tuple) or len(value) != count or not all(map(is_number, value)):
        raise shape.error(f"{shape.name}'s size must be a number or {count} of them")
    if not all(0 < v < math.inf for v in value):
        raise shape.error(f"{shape.name}'s size must be greater than zero all through")
    return np.array(value)


def centered(shape: Shape) -> bool:
    """Whether it is centered."""
    return true(shape.arguments.get("center"))


def points(shape: Shape, value: Value, dimension: int) -> Floats:
    """(n, dimension) coordinates."""
    rows = value if isinstance(value, tuple) else ()
    if len(rows) > MOST_POINTS[dimension]:
        most = MOST_POINTS[dimension]
        raise shape.error(f"{shape.name} has more than {most} points; export it as a mesh (STL)")
    good = [
        isinstance(row, tuple)
        and len(row) == dimension
        and all(is_number(x) and math.isfinite(x) for x in row)
        for row in rows
    ]
    if not rows or not all(good):
        raise shape.error(
            f"{shape.name}'s points must be [{', '.join('xyz'[:dimension])}], all finite numbers"
        )
    return np.array(rows, dtype=float)


def indices(shape: Shape, value: Value, count: int) -> list[list[int]]:
    """Lists of whole numbers below `count`."""
    rows = value if isinstance(value, tuple) else ()
    good = [
        isinstance(row, tuple) and all(is_number(i) and 0 <= i < count and i == int(i) for i in row)
        for row in rows
    ]
    if not rows or not all(good):
        raise shape.error(f"{shape.name} names points that are not there; check its indices")
    return [[int(i) for i in row] for row in rows]


def fragments(shape: Shape, radius: float) -> int:
    """How many sides OpenSCAD gives a circle of this radius [mm]."""
    fn, fa, fs = shape.facets
    if fn > 0:
        return int(min(max(fn, 3), 1000))
    return int(min(math.ceil(max(min(360 / max(fa, 0.01), 2 * math.pi * radius / max(fs, 0.01)), 5)), 1000))
