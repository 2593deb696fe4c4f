"""The triangles of a GLB, with node poses applied; only what a STEP reader writes (no sparse, no compression).

A GLB is a 12-byte header, a JSON chunk and a binary chunk (glTF 2.0, chapter 4); lengths are meters.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from primitives.arrays import Floats, Ints
from primitives.pose import from_quaternion

_NUMBERS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
_DEEPEST = 64  # nodes below one another
_TRIANGLES = 4
_FACES = "TM_brep_faces"  # cascadio's extension


class Primitive(NamedTuple):
    """One run of triangles of one node."""

    name: str
    vertices: Floats  # (v, 3) [m]
    normals: Floats  # (v, 3)
    triangles: Ints  # (t, 3)
    face: Ints | None  # (t,) index of each triangle's face in the CAD file; None where the GLB does not say
    described: list[Any]  # per face, the surface behind it: a dict, or None
    model_from_node: Floats  # (4, 4)


class Glb:
    """A parsed file; raises KeyError, ValueError, IndexError, TypeError or struct.error where it is broken."""

    def __init__(self, data: bytes) -> None:
        length = struct.unpack_from("<I", data, 12)[0]
        self.tree: dict[str, Any] = json.loads(data[20 : 20 + length])
        self._binary = data[28 + length :]

    def primitives(self) -> Iterator[Primitive]:
        """All triangles of the scene; points and lines are left out."""
        scene = self.tree.get("scenes", [{}])[self.tree.get("scene", 0)]
        for root in scene.get("nodes", []):
            yield from self._under(root, np.eye(4), "", 0)

    def accessor(self, number: int) -> NDArray[Any]:
        """The values behind an accessor: (count,) or (count, width)."""
        about = self.tree["accessors"][number]
        view = self.tree["bufferViews"][about["bufferView"]]
        kind, width = np.dtype(_NUMBERS[about["componentType"]]), _WIDTHS[about["type"]]
        start = view.get("byteOffset", 0) + about.get("byteOffset", 0)
        stride = view.get("byteStride", kind.itemsize * width)
        values = np.ndarray((about["count"], width), kind, self._binary, start, (stride, kind.itemsize))
        return values[:, 0] if width == 1 else values

    def _under(self, number: int, parent: Floats, name: str, depth: int) -> Iterator[Primitive]:
        if depth > _DEEPEST:
            raise ValueError("nodes are nested without end")
        node = self.tree["nodes"][number]
        here, label = parent @ _pose(node), str(node.get("name", name))
        if "mesh" in node:
            mesh = self.tree["meshes"][node["mesh"]]
            shown = name if label.startswith("=>") else label
            for run in mesh["primitives"]:
                if run.get("mode", _TRIANGLES) == _TRIANGLES and "indices" in run:
                    yield self._primitive(run, here, shown or str(mesh.get("name", "")))
        for child in node.get("children", []):
            yield from self._under(child, here, label, depth + 1)

    def _primitive(self, run: dict[str, Any], pose: Floats, name: str) -> Primitive:
        points = self.accessor(run["attributes"]["POSITION"]).astype(np.float64)
        normals = self.accessor(run["attributes"]["NORMAL"]).astype(np.float64)
        triangles = self.accessor(run["indices"]).astype(np.int64).reshape(-1, 3)
        faces = run.get("extensions", {}).get(_FACES, {})
        return Primitive(
            name,
            points @ pose[:3, :3].T + pose[:3, 3],
            normals @ pose[:3, :3].T,
            triangles,
            self.accessor(faces["faceIndices"]).astype(np.int64) if "faceIndices" in faces else None,
            list(faces.get("faces", [])),
            pose,
        )


def _pose(node: dict[str, Any]) -> Floats:
    if "matrix" in node:
        return np.array(node["matrix"], dtype=float).reshape(4, 4).T
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    moved = from_quaternion([w, x, y, z], node.get("translation", (0, 0, 0))).copy()
    moved[:3, :3] *= np.array(node.get("scale", (1, 1, 1)), dtype=float)
    return moved
