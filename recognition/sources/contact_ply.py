"""Contacts as a PLY point cloud: the vertex element's x, y, z, and nx, ny, nz and sigma where it has them."""

from __future__ import annotations

import io
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from primitives.arrays import Floats
from primitives.errors import PalpateError
from recognition.sources.bytes_of import bytes_of
from recognition.sources.columns import Columns

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8",
}  # fmt: skip
_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass
class _Element:
    name: str
    count: int
    names: list[str] = field(default_factory=list)
    types: list[str] = field(default_factory=list)
    lists: bool = False


def read_ply(path: Path) -> Columns:
    """The vertices of a PLY file, text or binary."""
    data = bytes_of(path)
    head, mark, _ = data[: 1 << 16].partition(b"end_header")
    if not head.startswith(b"ply") or not mark:
        raise PalpateError(f"{path.name} has no complete PLY header; export it again")
    body = data[data.index(b"\n", len(head)) + 1 :]
    form, elements = _header(head.decode("ascii", "replace"), path.name)
    before: list[_Element] = []
    for element in elements:
        if element.name == "vertex":
            return _columns(element, _rows(form, before, element, body, path.name), path.name)
        before.append(element)
    raise PalpateError(f"{path.name} has no vertices; give a PLY with x, y, z")


def _header(text: str, name: str) -> tuple[str, list[_Element]]:
    form, elements = "", list[_Element]()
    for line in text.splitlines():
        match line.split():
            case ["format", said, *_]:
                form = said
            case ["element", kind, count] if count.isdecimal():
                elements.append(_Element(kind, int(count)))
            case ["property", "list", *_] if elements:
                elements[-1].lists = True
            case ["property", said, label] if elements and said in _TYPES:
                elements[-1].names.append(label.lower())
                elements[-1].types.append(_TYPES[said])
    if form != "ascii" and form not in _ORDERS:
        raise PalpateError(f"{name} is PLY of an unknown format {form!r}; write it as ascii")
    return form, elements


def _rows(form: str, before: list[_Element], vertex: _Element, body: bytes, name: str) -> Floats:
    """(n, k) the vertex element's numbers."""
    truncated = PalpateError(f"{name} announces {vertex.count} vertices and holds fewer; export it again")
    if vertex.lists or any(element.lists for element in before):
        raise PalpateError(f"{name} has lists before or in its vertices; export it as a plain point cloud")
    if form == "ascii":
        lines = body.decode("ascii", "replace").splitlines()
        first = sum(element.count for element in before)
        mine = lines[first : first + vertex.count]
        if len(mine) < vertex.count:
            raise truncated
        try:
            return (
                np.loadtxt(io.StringIO("\n".join(mine)), ndmin=2)
                if mine
                else np.empty((0, len(vertex.names)))
            )
        except ValueError:
            raise PalpateError(f"{name} holds vertices that are not numbers; export it again") from None
    order = _ORDERS[form]
    skipped = sum(e.count * sum(np.dtype(t).itemsize for t in e.types) for e in before)
    kind = np.dtype([(str(i), order + t) for i, t in enumerate(vertex.types)])
    if len(body) - skipped < vertex.count * kind.itemsize:
        raise truncated
    table = np.frombuffer(body, kind, vertex.count, skipped)
    return np.column_stack([table[str(i)].astype(float) for i in range(len(vertex.types))])


def _columns(vertex: _Element, rows: Floats, name: str) -> Columns:
    at = {label: i for i, label in enumerate(vertex.names)}
    if any(axis not in at for axis in "xyz") or rows.shape[1] < len(vertex.names):
        raise PalpateError(f"{name} has vertices without x, y, z; export it as a plain point cloud")
    normals = [at[label] for label in ("nx", "ny", "nz") if label in at]
    return Columns(
        rows[:, [at[axis] for axis in "xyz"]],
        rows[:, normals] if len(normals) == 3 else None,
        rows[:, at["sigma"]] if "sigma" in at else None,
    )
