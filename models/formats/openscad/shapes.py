"""What a file draws, flat: named shapes with their arguments, as OpenSCAD's own `.csg` has them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from models.formats.openscad.values import Value
from primitives.errors import PalpateError

# name -> its arguments in order, or the reason why it is not read
ARGUMENTS: dict[str, tuple[str, ...]] = {
    "group": (),
    "union": (),
    "difference": (),
    "intersection": (),
    "render": ("convexity",),
    "color": ("c", "alpha"),
    "multmatrix": ("m",),
    "translate": ("v",),
    "rotate": ("a", "v"),
    "scale": ("v",),
    "mirror": ("v",),
    "resize": ("newsize", "auto", "convexity"),
    "cube": ("size", "center"),
    "cylinder": ("h", "r1", "r2", "center", "r", "d", "d1", "d2"),
    "sphere": ("r", "d"),
    "polyhedron": ("points", "faces", "convexity", "triangles"),
    "square": ("size", "center"),
    "circle": ("r", "d"),
    "polygon": ("points", "paths", "convexity"),
    "linear_extrude": ("height", "center", "convexity", "twist", "slices", "scale"),
    "rotate_extrude": ("angle", "convexity"),
    "hull": (),
    "offset": ("r", "delta", "chamfer"),
    "minkowski": ("convexity",),
}
RENAMED = {("linear_extrude", "h"): "height"}
REFUSED_ARGUMENTS = {
    ("linear_extrude", "file"): "draw the outline as a polygon",
    ("rotate_extrude", "file"): "draw the outline as a polygon",
    ("linear_extrude", "v"): "give height, and turn the solid with rotate()",
    ("rotate_extrude", "start"): "turn the solid with rotate()",
}
CHILDLESS = frozenset({"cube", "cylinder", "sphere", "polyhedron", "square", "circle", "polygon"})
REFUSED = {
    "import": "load the mesh itself, or draw its shape with primitives",
    "surface": "load it as a mesh (STL) instead",
    "text": "draw the letters as polygons, or leave them out",
    "projection": "draw the outline as a polygon",
    "roof": "draw it as a polyhedron",
    "fill": "draw the outline as it is to be",
    "assign": "use let() instead",
    "dxf_linear_extrude": "draw the outline as a polygon",
    "dxf_rotate_extrude": "draw the outline as a polygon",
    "import_stl": "load the mesh itself",
    "import_dxf": "draw the outline as a polygon",
    "import_off": "load the mesh itself",
}


@dataclass
class Shape:
    """One node of what a file draws."""

    name: str
    place: str  # file and line, as errors show them
    arguments: Mapping[str, Value] = field(default_factory=dict)
    children: list[Shape] = field(default_factory=list)
    label: str = ""  # the comment line right above it
    facets: tuple[float, float, float] = (0.0, 12.0, 2.0)  # $fn, $fa [deg], $fs [mm]
    root: bool = False  # marked with !

    def error(self, words: str) -> PalpateError:
        """An error that names the line."""
        return PalpateError(f"{self.place}: {words}")

    def shown_root(self) -> Shape | None:
        """The first shape marked with `!`, here or below."""
        if self.root:
            return self
        for child in self.children:
            if (found := child.shown_root()) is not None:
                return found
        return None
