"""Meshes in (STL, OBJ, PLY, OFF, GLB) and out (STL, PLY, GLB), in mm; broken files become one line.

Out, numbers are mm in every format; a GLB says so in its `asset.extras`, because the format's own unit is the
meter, which is what `load` takes any other GLB to be in.
"""

from __future__ import annotations

import io
import logging
import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import trimesh

from models.formats import intake, off
from models.stitch import stitched
from models.topology import merged, open_edges, wound
from primitives.arrays import Floats, Ints, frozen
from primitives.errors import PalpateError
from primitives.surface import TriangleSurface

Units = Literal["auto", "mm", "cm", "m", "in"]
SUFFIXES = (".stl", ".obj", ".ply", ".off", ".glb")
OUT_SUFFIXES = (".stl", ".ply", ".glb")
_MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}


@dataclass(frozen=True)
class SizeLimits:
    """What a part may measure along its longest side."""

    least: float = 1.0  # [mm]
    small: float = 10.0  # [mm] warned about below
    large: float = 1000.0  # [mm] warned about above
    most: float = 10_000.0  # [mm]


@dataclass(frozen=True, eq=False)
class LoadedMesh:
    """A closed mesh, its normals out."""

    vertices: Floats  # (v, 3) [mm]
    triangles: Ints  # (t, 3)
    warnings: tuple[str, ...]


def load(
    path: str | Path, units: Units = "auto", scale: float = 1.0, limits: SizeLimits | None = None
) -> LoadedMesh:
    """The closed mesh in a file; `units` is the file's, auto takes the format's own or mm."""
    file = Path(path)
    name, suffix = file.name, file.suffix.lower()
    if units not in get_args(Units):
        raise PalpateError(f"no unit {units!r}; use one of {', '.join(get_args(Units))}")
    if not (np.isfinite(scale) and scale > 0):
        raise PalpateError(f"the scale must be a positive number, not {scale}")
    if suffix not in SUFFIXES and not file.is_dir() and file.exists():
        raise PalpateError(f"cannot read {name}: {suffix or 'no'} extension; use one of {' '.join(SUFFIXES)}")
    data = intake.checked(intake.read(file), suffix, name)
    vertices, triangles, own_unit = _parse(data, suffix, name)
    if not len(triangles):
        raise PalpateError(f"{name} has no faces; export it as a solid")
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        raise PalpateError(f"{name} has faces with corners that do not exist; export it again")
    if not np.isfinite(vertices[np.unique(triangles)]).all():
        raise PalpateError(f"{name} has coordinates that are not finite numbers; export it again")
    unit = own_unit if units == "auto" else units
    vertices = vertices * (_MM[unit or "mm"] * scale)
    used = vertices[np.unique(triangles)]
    said = _size_warnings(float(np.ptp(used, axis=0).max()), name, unit is None, limits or SizeLimits())
    return _closed(vertices, triangles, name, said)


def save(surface: TriangleSurface, path: str | Path) -> None:
    """Write a surface as it is placed; the file appears whole or not at all."""
    file = Path(path)
    suffix = file.suffix.lower()
    if suffix not in OUT_SUFFIXES:
        raise PalpateError(f"cannot write {file.name}; use one of {' '.join(OUT_SUFFIXES)}")
    mesh = trimesh.Trimesh(np.array(surface.vertices), np.array(surface.triangles), process=False)
    data = mesh.export(file_type=suffix[1:]) if suffix != ".glb" else _glb(mesh)
    partial = file.with_name(f".{file.name}.{os.getpid()}.partial")
    try:
        partial.write_bytes(data)
        partial.replace(file)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise PalpateError(f"cannot write {file} ({error.strerror}); choose another folder") from None


def _glb(mesh: Any) -> bytes:
    def say_unit(tree: dict[str, Any]) -> None:
        tree["asset"]["extras"] = {"unit": "mm"}

    data: bytes = trimesh.exchange.gltf.export_glb(trimesh.Scene(mesh), tree_postprocessor=say_unit)
    return data


def _parse(data: bytes, suffix: str, name: str) -> tuple[Floats, Ints, Units | None]:
    """Vertices, triangles and the unit that the file itself gives."""
    if suffix == ".off":
        return *off.parse(data, name), None
    try:
        options = {"skip_materials": True} if suffix == ".obj" else {}
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
    if suffix != ".glb":
        return vertices, triangles, None
    return vertices, triangles, "mm" if b'"extras":{"unit":"mm"}' in data[:65536].replace(b" ", b"") else "m"


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


def _size_warnings(size: float, name: str, guessed: bool, limits: SizeLimits) -> tuple[str, ...]:
    fits = [u for u, f in _MM.items() if limits.small <= size * f <= limits.large]
    hint = f"give its unit, for example --units {fits[-1]}" if fits else "give --units or --scale"
    if size < limits.least:
        raise PalpateError(f"{name} is {size:.3g} mm across, less than {limits.least:g} mm; {hint}")
    if size > limits.most:
        raise PalpateError(f"{name} is {size:.3g} mm across, more than 10 m; give --units or --scale")
    if guessed and not limits.small <= size <= limits.large:
        return (f"{name} is {size:.3g} mm across if it is in mm; if not, {hint}",)
    return ()


def _closed(vertices: Floats, triangles: Ints, name: str, said: tuple[str, ...]) -> LoadedMesh:
    size = float(np.ptp(vertices, axis=0).max())
    for grid in (0.0, 1e-6 * size, 1e-5 * size):
        points, corners = merged(vertices, triangles, grid)
        if not len(corners):
            raise PalpateError(f"{name} has only triangles without area; export it again")
        if open_edges(corners) == 0:
            break
    if open_edges(corners) > 0:
        corners = stitched(points, corners, 1e-5 * size)
    if len(corners) < 4:
        count = f"{len(corners)} triangle" + "s" * (len(corners) > 1)
        raise PalpateError(f"{name} has only {count}, which enclose nothing; export it as a solid")
    corners, turned = wound(points, corners)
    if (missing := open_edges(corners)) > 0:
        raise PalpateError(f"{name} is not closed: {missing} open edges; repair it in a mesh editor first")
    if turned:
        said = (*said, f"{name} had triangles that faced inward; they were turned")
    return LoadedMesh(frozen(points), frozen(corners, np.int64), said)
