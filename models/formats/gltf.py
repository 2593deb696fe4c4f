"""GLB and `.gltf` in: one mesh for each node; meters, or mm where our own note in `asset.extras` says so."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from models.formats import intake
from models.formats.gltf_arrays import BROKEN, Gltf, Primitive
from models.formats.labeled import LabeledMesh
from primitives.errors import PalpateError

SUFFIXES = (".glb", ".gltf")
_COMPRESSED = ("KHR_draco_mesh_compression", "EXT_meshopt_compression")


def parse(file: Path, data: bytes) -> tuple[list[LabeledMesh], float]:
    """The meshes in the file's numbers, and how many mm one is worth."""
    name = file.name
    broken = PalpateError(f"{name} is not a whole glTF file; export it again")
    try:
        scene = (
            Gltf.of_glb(data)
            if data[:4] == b"glTF"
            else Gltf((tree := json.loads(data)), _beside(file, tree.get("buffers", [])))
        )
        for extension in scene.tree.get("extensionsRequired", []):
            if extension in _COMPRESSED:
                raise PalpateError(f"{name} is compressed ({extension}); export it without compression")
        intake.check_triangles(scene.triangle_count(), name)
        groups: dict[int, list[Primitive]] = {}
        total = 0
        for run in scene.primitives():
            groups.setdefault(run.place, []).append(run)
            total += len(run.triangles)
            intake.check_triangles(total, name)
        unit = scene.tree.get("asset", {}).get("extras", {})
    except BROKEN:
        raise broken from None
    own = isinstance(unit, dict) and unit.get("unit") == "mm"
    return [_joined(runs) for runs in groups.values()], 1.0 if own else 1000.0


def _joined(runs: list[Primitive]) -> LabeledMesh:
    starts = np.cumsum([0, *(len(run.vertices) for run in runs[:-1])])
    triangles = [run.triangles + start for run, start in zip(runs, starts, strict=True)]
    vertices = np.concatenate([run.vertices for run in runs])
    return LabeledMesh.of(vertices, np.concatenate(triangles), runs[0].name)


def _beside(file: Path, buffers: list[Any]) -> Callable[[int], bytes]:
    """Buffers inside the text, or in files of the same folder and nowhere else."""

    def buffer(number: int) -> bytes:
        uri = str(buffers[number]["uri"])
        if uri.startswith("data:"):
            return base64.b64decode(uri.split(",", 1)[1])
        place = (file.parent / uri).resolve()
        if place.parent != file.parent.resolve():
            raise PalpateError(f"{file.name} asks for {uri[:60]!r}, outside its folder; save it as GLB")
        return intake.read(place)

    return buffer
