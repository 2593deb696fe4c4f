"""The XML of one 3MF model: objects with vertices and triangles, components, and what is to be built."""

from __future__ import annotations

from array import array
from collections.abc import Callable
from dataclasses import dataclass, field
from xml.parsers import expat

import numpy as np

from primitives.arrays import Floats, Ints, frozen
from primitives.errors import PalpateError


@dataclass(frozen=True, eq=False)
class Reference:
    """An object to be placed."""

    object: str  # id
    pose: Floats  # (4, 4) multiplied from the right onto row vectors
    path: str = ""  # of another model in the archive


@dataclass(frozen=True, eq=False)
class Object3mf:
    """A mesh, or components, or neither."""

    name: str
    kind: str  # "model", or what it is else
    vertices: Floats  # (v, 3) in the model's unit
    triangles: Ints  # (t, 3)
    components: tuple[Reference, ...]


@dataclass(frozen=True, eq=False)
class Model:
    """One model file."""

    unit: str
    objects: dict[str, Object3mf]
    items: tuple[Reference, ...]


def read_model(text: bytes, name: str) -> Model:
    """Parse; entities and document types are refused, so nothing in the text can grow or reach out."""
    reader = _Reader()
    parser = expat.ParserCreate(namespace_separator=" ")
    parser.StartElementHandler = reader.start
    parser.EndElementHandler = reader.end
    parser.StartDoctypeDeclHandler = _refuse
    parser.EntityDeclHandler = _refuse
    try:
        parser.Parse(text, True)
    except (expat.ExpatError, ValueError, KeyError, OverflowError):
        raise PalpateError(f"{name} holds a model that is broken XML or not 3MF; export it again") from None
    return Model(reader.unit, reader.objects, tuple(reader.items))


def _refuse(*_: object) -> None:
    raise ValueError("document types are not part of 3MF")


@dataclass
class _Reader:
    unit: str = "millimeter"
    objects: dict[str, Object3mf] = field(default_factory=dict)
    items: list[Reference] = field(default_factory=list)
    _id: str = ""
    _name: str = ""
    _kind: str = ""
    _vertices: array[float] = field(default_factory=lambda: array("d"))
    _triangles: array[int] = field(default_factory=lambda: array("q"))
    _components: list[Reference] = field(default_factory=list)

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        """An element opens."""
        if handler := _HANDLERS.get(tag.rsplit(" ", 1)[-1]):
            handler(self, attributes)

    def end(self, tag: str) -> None:
        """An element closes."""
        if tag.rsplit(" ", 1)[-1] == "object":
            self.objects[self._id] = Object3mf(
                self._name,
                self._kind,
                frozen(np.array(self._vertices).reshape(-1, 3)),
                frozen(np.array(self._triangles, dtype=np.int64).reshape(-1, 3), np.int64),
                tuple(self._components),
            )

    def model(self, attributes: dict[str, str]) -> None:
        """The root."""
        self.unit = attributes.get("unit", "millimeter")

    def object(self, attributes: dict[str, str]) -> None:
        """An object opens."""
        self._id, self._name = attributes["id"], attributes.get("name", "")
        self._kind = attributes.get("type", "model")
        self._vertices, self._triangles, self._components = array("d"), array("q"), []

    def vertex(self, attributes: dict[str, str]) -> None:
        """A corner."""
        self._vertices.extend((float(attributes["x"]), float(attributes["y"]), float(attributes["z"])))

    def triangle(self, attributes: dict[str, str]) -> None:
        """Three corners."""
        self._triangles.extend((int(attributes["v1"]), int(attributes["v2"]), int(attributes["v3"])))

    def component(self, attributes: dict[str, str]) -> None:
        """Another object as part of this one."""
        self._components.append(_reference(attributes))

    def item(self, attributes: dict[str, str]) -> None:
        """An object to build."""
        self.items.append(_reference(attributes))


_HANDLERS: dict[str, Callable[[_Reader, dict[str, str]], None]] = {
    kind: getattr(_Reader, kind) for kind in ("model", "object", "vertex", "triangle", "component", "item")
}


def _reference(attributes: dict[str, str]) -> Reference:
    pose = np.eye(4)
    if words := attributes.get("transform", "").split():
        pose[:, :3] = np.array([float(word) for word in words]).reshape(4, 3)
    path = next((value for key, value in attributes.items() if key.rsplit(" ", 1)[-1] == "path"), "")
    return Reference(attributes["objectid"], frozen(pose), path)
