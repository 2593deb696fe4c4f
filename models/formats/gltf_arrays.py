"""The triangles of a glTF scene (GLB or `.gltf`), with node poses applied; lengths are meters.

A GLB is a 12-byte header, a JSON chunk and a binary chunk (glTF 2.0, chapter 4).  Sparse and compressed arrays
are not read.  Broken files raise what `BROKEN` lists; counts are held against the bytes there are.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from primitives.arrays import Floats, Ints
from primitives.pose import from_quaternion

BROKEN = (KeyError, ValueError, IndexError, TypeError, AttributeError, struct.error, RecursionError)
_NUMBERS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
_DEEPEST = 64  # nodes below one another
_MOST_NODES = 5_000
_FACES = "TM_brep_faces"  # cascadio's extension


class Primitive(NamedTuple):
    """One run of triangles of one node."""

    place: int  # the same for all runs of one node where it stands
    name: str
    vertices: Floats  # (v, 3) [m]
    normals: Floats | None  # (v, 3)
    triangles: Ints  # (t, 3)
    face: Ints | None  # (t,) index of each triangle's face in the CAD file; None where the GLB does not say
    described: list[Any]  # per face, the surface behind it: a dict, or None
    model_from_node: Floats  # (4, 4)


class Gltf:
    """A parsed file."""

    def __init__(self, tree: dict[str, Any], buffers: Callable[[int], bytes]) -> None:
        self.tree = tree
        self._buffer = buffers
        self._visits = 0

    @staticmethod
    def of_glb(data: bytes) -> Gltf:
        """From the bytes of a GLB."""
        length = struct.unpack_from("<I", data, 12)[0]
        return Gltf(json.loads(data[20 : 20 + length]), lambda _: data[28 + length :])

    def primitives(self) -> Iterator[Primitive]:
        """All triangles of the scene; points and lines are left out."""
        scene = self.tree.get("scenes", [{}])[self.tree.get("scene", 0)]
        for root in scene.get("nodes", []):
            yield from self._under(root, np.eye(4), "", 0)

    def triangle_count(self) -> int:
        """Of all index arrays that the file announces."""
        runs = [run for mesh in self.tree.get("meshes", []) for run in mesh["primitives"]]
        numbers = [run.get("indices", run["attributes"]["POSITION"]) for run in runs]
        return sum(int(self.tree["accessors"][number]["count"]) for number in numbers) // 3

    def accessor(self, number: int) -> NDArray[Any]:
        """The values behind an accessor: (count,) or (count, width)."""
        about = self.tree["accessors"][_index(number)]
        if "sparse" in about:
            raise ValueError("sparse arrays")
        view = self.tree["bufferViews"][_index(about["bufferView"])]
        data = self._buffer(_index(view.get("buffer", 0)))
        kind, width = np.dtype(_NUMBERS[about["componentType"]]), _WIDTHS[about["type"]]
        start = _index(view.get("byteOffset", 0)) + _index(about.get("byteOffset", 0))
        stride = _index(view.get("byteStride", kind.itemsize * width))
        shape = (_index(about["count"]), width)
        values: NDArray[Any] = np.ndarray(shape, kind, data, start, (stride, kind.itemsize))
        if about.get("normalized"):
            values = np.maximum(values / np.iinfo(kind).max, -1.0)
        return values[:, 0] if width == 1 else values

    def _under(self, number: int, parent: Floats, name: str, depth: int) -> Iterator[Primitive]:
        self._visits += 1
        if depth > _DEEPEST or self._visits > _MOST_NODES:
            raise ValueError("nodes without end")
        place, node = self._visits, self.tree["nodes"][_index(number)]
        here, label = parent @ _pose(node), str(node.get("name", name))
        if "mesh" in node:
            mesh = self.tree["meshes"][_index(node["mesh"])]
            shown = name if label.startswith("=>") else label
            for run in mesh["primitives"]:
                if run.get("mode", 4) in _MODES:
                    yield self._primitive(run, place, here, shown or str(mesh.get("name", "")))
        for child in node.get("children", []):
            yield from self._under(child, here, label, depth + 1)

    def _primitive(self, run: dict[str, Any], place: int, pose: Floats, name: str) -> Primitive:
        points = self.accessor(run["attributes"]["POSITION"]).astype(np.float64).reshape(-1, 3)
        normals = None
        if "NORMAL" in run["attributes"]:
            normals = self.accessor(run["attributes"]["NORMAL"]).astype(np.float64) @ pose[:3, :3].T
        order = self.accessor(run["indices"]).astype(np.int64) if "indices" in run else np.arange(len(points))
        triangles = _MODES[run.get("mode", 4)](order)
        if float(np.linalg.det(pose[:3, :3])) < 0:
            triangles = triangles[:, ::-1]
        faces = run.get("extensions", {}).get(_FACES, {})
        return Primitive(
            place,
            name,
            points @ pose[:3, :3].T + pose[:3, 3],
            normals,
            triangles,
            self.accessor(faces["faceIndices"]).astype(np.int64) if "faceIndices" in faces else None,
            list(faces.get("faces", [])),
            pose,
        )


def _strip(order: Ints) -> Ints:
    out = np.stack([order[:-2], order[1:-1], order[2:]], axis=1)
    out[1::2] = out[1::2][:, [1, 0, 2]]
    return out


def _fan(order: Ints) -> Ints:
    return np.stack([np.full(len(order) - 2, order[0]), order[1:-1], order[2:]], axis=1)


_MODES: dict[int, Callable[[Ints], Ints]] = {4: lambda order: order.reshape(-1, 3), 5: _strip, 6: _fan}


def _index(value: Any) -> int:
    """A count or place, which a file may not make negative: Python would count from the end."""
    number = int(value)
    if number < 0:
        raise ValueError("a negative index")
    return number


def _pose(node: dict[str, Any]) -> Floats:
    if "matrix" in node:
        return np.array(node["matrix"], dtype=float).reshape(4, 4).T
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    moved = from_quaternion([w, x, y, z], node.get("translation", (0, 0, 0))).copy()
    moved[:3, :3] *= np.array(node.get("scale", (1, 1, 1)), dtype=float)
    return moved
