"""Meshes in (STL, OBJ, PLY, OFF) and out (STL, PLY, GLB), in mm; broken files become one line.

Out, numbers are mm in every format; a GLB says so in its `asset.extras`, because the format's own unit is the
meter, which is what any other GLB is taken to be in (`gltf`).
"""

from __future__ import annotations

import io
import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from models.formats import obj, off
from models.formats.whole_file import write_whole
from primitives.arrays import Floats, Ints
from primitives.errors import PalpateError
from primitives.surface import TriangleSurface

SUFFIXES = (".stl", ".obj", ".ply", ".off")
OUT_SUFFIXES = (".stl", ".ply", ".glb")
_OWN = {".obj": obj.parse, ".off": off.parse}
_OPTIONS = {".ply": {"skip_materials": True, "fix_texture": False}}


def save(surface: TriangleSurface, path: str | Path) -> None:
    """Write a surface as it is placed; the file appears whole or not at all."""
    file = Path(path)
    suffix = file.suffix.lower()
    if suffix not in OUT_SUFFIXES:
        raise PalpateError(f"cannot write {file.name}; use one of {' '.join(OUT_SUFFIXES)}")
    mesh = trimesh.Trimesh(np.array(surface.vertices), np.array(surface.triangles), process=False)
    data = mesh.export(file_type=suffix[1:]) if suffix != ".glb" else _glb(mesh)
    write_whole(file, data)


def _glb(mesh: Any) -> bytes:
    def say_unit(tree: dict[str, Any]) -> None:
        tree["asset"]["extras"] = {"unit": "mm"}

    data: bytes = trimesh.exchange.gltf.export_glb(trimesh.Scene(mesh), tree_postprocessor=say_unit)
    return data


def parse(data: bytes, suffix: str, name: str) -> tuple[Floats, Ints]:
    """Vertices and triangles in the file's numbers."""
    if suffix in _OWN:
        return _OWN[suffix](data, name)
    try:
        options = _OPTIONS.get(suffix, {})
        with _quiet_trimesh():
            loaded = trimesh.load(io.BytesIO(data), file_type=suffix[1:], process=False, **options)
        mesh = loaded.to_geometry() if isinstance(loaded, trimesh.Scene) else loaded
        vertices = np.array(mesh.vertices, dtype=np.float64).reshape(-1, 3)
        faces = getattr(mesh, "faces", None)
        triangles = np.array([] if faces is None else faces, dtype=np.int64).reshape(-1, 3)
    except Exception as error:  # a parser outside may raise anything on a broken file
        reason = " ".join(str(error).split())[:80] or type(error).__name__
        raise PalpateError(
            f"cannot read {name} as {suffix[1:].upper()} ({reason}); export it again"
        ) from None
    return vertices, triangles


@contextmanager
def _quiet_trimesh() -> Iterator[None]:
    """Without the tracebacks that trimesh logs for files it then reads another way."""
    log, nowhere = logging.getLogger("trimesh"), logging.NullHandler()
    log.addHandler(nowhere)
    passed_on, log.propagate = log.propagate, False
    try:
        with warnings.catch_warnings(action="ignore"):
            yield
    finally:
        log.removeHandler(nowhere)
        log.propagate = passed_on
