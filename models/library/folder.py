"""The CAD files of a folder, each with its name, its settings and a key that changes when its object may.

A file's name is its shown name (`library.toml`), else its stem; where two files would share one, both are called
by their whole file names.  The key is a hash of the content, of the settings and of every file that the
content names (OpenSCAD's include, use and import; the buffers of a .gltf).
"""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from models.formats.intake import DRAWINGS, SUFFIXES
from models.library.settings import FILE, FileSettings, FolderSettings
from primitives.errors import PalpateError

VERSION = 4  # of what is made of a file; entries of another one are made again
_NAMED = {
    **dict.fromkeys(DRAWINGS, re.compile(rb"(?:include|use)\s*<([^>\n]+)>|import\s*\([^)\"]*\"([^\"\n]+)\"")),
    ".gltf": re.compile(rb"\"uri\"\s*:\s*\"([^\"\n]+)\""),
}
_MOST_NAMED = 200  # files that one may name, those that they name among them


@dataclass(frozen=True)
class ModelFile:
    """A CAD file of the folder."""

    name: str  # of the object
    path: Path
    settings: FileSettings


Stamp = tuple[int, int]  # size [bytes] and time of the last change [ns]


def model_files(folder: Path, settings: FolderSettings) -> tuple[ModelFile, ...]:
    """The CAD files of a folder, by name."""
    found = _listed(folder)
    shown = {path: settings.of(path.name).name for path in found}
    count = Counter(shown[path] or path.stem for path in found)
    names = {}
    for path in found:
        name = shown[path] or path.stem
        names[path] = name if count[name] == 1 else path.name
        if shown[path] and count[name] > 1:
            raise PalpateError(f"{folder / FILE} shows two files as {name!r}; give each a name of its own")
    return tuple(ModelFile(names[path], path, settings.of(path.name)) for path in found)


def strays(folder: Path, settings: FolderSettings) -> tuple[str, ...]:
    """What `library.toml` speaks of and is not there, one line each."""
    return tuple(
        f"{FILE} speaks of {name}, which is not in the folder"
        for name in settings.files
        if not (folder / name).exists()
    )


def stamp(path: str | Path) -> Stamp:
    """Of a file as it is now; (-1, 0) for one that is gone."""
    try:
        status = os.stat(path)
    except OSError:
        return -1, 0
    return status.st_size, status.st_mtime_ns


def content_key(file: ModelFile) -> tuple[str, dict[str, Stamp]]:
    """The key of a file, and the stamps of all that it was made from, by their paths from the folder."""
    folder = file.path.parent
    stamps, digest = {}, hashlib.sha256()
    digest.update(json.dumps([VERSION, file.path.suffix.lower(), file.settings.as_json()]).encode())
    queue, seen = [file.path], {file.path}
    while queue:
        path = queue.pop(0)
        stamps[os.path.relpath(path, folder)] = stamp(path)
        try:
            data = path.read_bytes()
        except OSError:
            data = b"gone"
        digest.update(hashlib.sha256(data).digest())
        for named in _named(path, data):
            if named not in seen and len(seen) < _MOST_NAMED:
                seen.add(named)
                queue.append(named)
    return digest.hexdigest()[:32], stamps


def _named(path: Path, data: bytes) -> list[Path]:
    pattern = _NAMED.get(path.suffix.lower())
    if pattern is None:
        return []
    words = [next(filter(None, groups.groups())) for groups in pattern.finditer(data)]
    texts = [word.decode("utf-8", "replace") for word in words if not word.startswith(b"data:")]
    return [path.parent / text for text in texts if "\0" not in text]


def _listed(folder: Path) -> list[Path]:
    try:
        with os.scandir(folder) as entries:
            names = sorted(entry.name for entry in entries if _is_model(entry))
    except FileNotFoundError:
        raise PalpateError(f"no folder {folder}; give a folder of CAD files") from None
    except NotADirectoryError:
        raise PalpateError(f"{folder} is a file; give the folder that it is in") from None
    except OSError as error:
        raise PalpateError(f"{folder} cannot be read ({error.strerror}); change its permissions") from None
    return [folder / name for name in names]


def _is_model(entry: os.DirEntry[str]) -> bool:
    suffix = os.path.splitext(entry.name)[1].lower()
    return suffix in SUFFIXES and not entry.name.startswith(".") and not entry.is_dir()
