"""3MF in: a ZIP archive with a model in XML, its unit, objects, components and where they are placed.

A placement is twelve numbers, the rows of a 4x3 matrix that multiplies row vectors (3MF core 1.3, section 3.3).
Nothing is unpacked to disk; what an archive would inflate to is added up before any of it is.
"""

from __future__ import annotations

import io
import posixpath
import re
import zipfile
import zlib
from collections.abc import Iterator
from typing import NamedTuple
from urllib.parse import unquote

import numpy as np

from models.formats import intake
from models.formats.labeled import LabeledMesh
from models.formats.threemf_model import Model, Reference, read_model
from primitives.arrays import Floats
from primitives.errors import PalpateError

SUFFIXES = (".3mf",)
MOST_INFLATED = 1_000_000_000  # [bytes]
_MOST_ENTRIES = 10_000
_MOST_PLACED = 1_000  # meshes
_DEEPEST = 32
_AROUND = ("support", "solidsupport")  # objects that a printer builds to hold the part
_MM = {"micron": 1e-3, "millimeter": 1.0, "centimeter": 10.0, "inch": 25.4, "foot": 304.8, "meter": 1000.0}


class _Archive(NamedTuple):
    files: zipfile.ZipFile
    models: dict[str, Model]
    name: str


def parse(data: bytes, name: str) -> tuple[list[LabeledMesh], float]:
    """The placed meshes in the file's numbers, and how many mm one is worth."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as files:
            entries = files.infolist()
            inflated = sum(entry.file_size for entry in entries)
            if inflated > MOST_INFLATED or len(entries) > _MOST_ENTRIES:
                size = f"{inflated / 1e9:.1f} GB in {len(entries)} files"
                raise PalpateError(f"{name} would inflate to {size}, more than 1 GB; export it again")
            archive = _Archive(files, {}, name)
            root = _root(archive)
            model = _model(archive, root)
            if model.unit not in _MM:
                raise PalpateError(
                    f"{name} is in the unit {model.unit[:20]!r}, which 3MF has not; use millimeter"
                )
            placed = list(_built(archive, root, model))
    except (zipfile.BadZipFile, zlib.error, OSError, EOFError, NotImplementedError, RuntimeError):
        raise PalpateError(f"{name} is not a whole 3MF archive; export it again") from None
    return placed, _MM[model.unit]


def _root(archive: _Archive) -> str:
    """The path of the model that the archive's own relationships name."""
    if "_rels/.rels" in archive.files.namelist():
        text = _text(archive, "_rels/.rels")
        for relation in re.findall(rb"<(?:\w+:)?Relationship\b[^>]*>", text):
            kind = re.search(rb'Type\s*=\s*["\'][^"\']*/3dmodel["\']', relation)
            target = re.search(rb'Target\s*=\s*["\']([^"\']+)["\']', relation)
            if kind and target:
                return _inside(target[1].decode("utf-8", "replace"))
    models = [entry for entry in archive.files.namelist() if entry.lower().endswith(".model")]
    if not models:
        raise PalpateError(f"{archive.name} has no 3-D model in it; export it again as 3MF")
    return models[0]


def _model(archive: _Archive, path: str) -> Model:
    if path not in archive.models:
        archive.models[path] = read_model(_text(archive, path), archive.name)
    return archive.models[path]


def _text(archive: _Archive, path: str) -> bytes:
    """A part of the archive; names differ by more than their case (OPC, section 6.2.2.3)."""
    for entry in archive.files.namelist():
        if entry.lstrip("/").lower() == path.lower():
            return archive.files.read(entry)
    raise PalpateError(f"{archive.name} names {path[:60]!r}, which is not in it; export it again")


def _inside(path: str) -> str:
    """A path of the archive, whose root nothing leaves."""
    return posixpath.normpath("/" + unquote(path).replace("\\", "/")).lstrip("/")


def _built(archive: _Archive, root: str, model: Model) -> Iterator[LabeledMesh]:
    """Every mesh of every placed object."""
    if not model.items:
        raise PalpateError(f"{archive.name} places none of its objects; export it again")
    triangles = count = 0
    for item in model.items:
        for placed in _placed(archive, root, item, np.eye(4), 0, [0]):
            count, triangles = count + 1, triangles + len(placed.triangles)
            intake.check_triangles(triangles, archive.name)
            if count > _MOST_PLACED:
                raise PalpateError(f"{archive.name} places more than {_MOST_PLACED} meshes; export fewer")
            yield placed


def _placed(
    archive: _Archive, path: str, told: Reference, parent: Floats, depth: int, visits: list[int]
) -> Iterator[LabeledMesh]:
    path = _inside(told.path) if told.path else path
    model = _model(archive, path)
    found = model.objects.get(told.object)
    visits[0] += 1
    if found is None or depth > _DEEPEST or visits[0] > 10 * _MOST_PLACED:
        why = "that is not there" if found is None else "built of itself without end"
        raise PalpateError(f"{archive.name} places the object {told.object[:20]!r} {why}; export it again")
    if found.kind in _AROUND:
        return
    pose = told.pose @ parent
    if len(found.triangles):
        points = found.vertices @ pose[:3, :3] + pose[3, :3]
        mirrored = float(np.linalg.det(pose[:3, :3])) < 0
        yield LabeledMesh.of(points, found.triangles[:, :: -1 if mirrored else 1], found.name)
    for component in found.components:
        yield from _placed(archive, path, component, pose, depth + 1, visits)
