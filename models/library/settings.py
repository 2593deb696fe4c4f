"""What `library.toml` says of a folder of CAD files::

    units = "mm"            # of every file that says nothing itself; so may scale and facets

    ["bolt.stl"]            # a file in the folder
    name = "M8 bolt"        # shown in its place
    units = "in"
    scale = 1.0
    body = 2                # of a file that holds several
    facets = false          # true keeps the flat sides of OpenSCAD's circles
    material = "steel"      # a word, or a FILE.toml as `--material` takes it

Without it, `--units` and `--scale` hold for all.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, cast

from models.formats.units import Units, checked_flags
from primitives.errors import PalpateError

FILE = "library.toml"


@dataclass(frozen=True)
class FileSettings:
    """How one file is read."""

    units: Units = "auto"
    scale: float = 1.0
    body: int | None = None
    facets: bool = False
    name: str = ""  # shown in place of the file's
    material: str = ""

    def as_json(self) -> dict[str, Any]:
        """Everything that changes what is made of the file."""
        return {"units": self.units, "scale": self.scale, "body": self.body, "facets": self.facets}


@dataclass(frozen=True)
class FolderSettings:
    """Of every file, and of those that are named."""

    every: FileSettings = FileSettings()
    files: Mapping[str, FileSettings] = field(default_factory=dict)

    def of(self, file: str) -> FileSettings:
        """Of one file, by its name in the folder."""
        return self.files.get(file, self.every)


def read_settings(folder: Path, units: str = "auto", scale: float = 1.0) -> FolderSettings:
    """Of a folder, with or without its `library.toml`."""
    checked_flags(units, scale)
    base = FileSettings(cast(Units, units), float(scale))
    path = folder / FILE
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (FileNotFoundError, NotADirectoryError):
        return FolderSettings(base)
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        reason = (isinstance(error, OSError) and error.strerror) or str(error).splitlines()[0]
        raise PalpateError(f"{path} is not readable TOML: {reason}; correct or remove it") from None
    told = table.pop("files", {})
    files = {**(told if isinstance(told, dict) else {}), **_pop_tables(table)}
    every = _settings(table, base, f"{path}", ("units", "scale", "facets"))
    known = ("units", "scale", "body", "facets", "name", "material")
    return FolderSettings(
        every, {key: _settings(t, every, f'{path} ["{key}"]', known) for key, t in files.items()}
    )


def _pop_tables(table: dict[str, Any]) -> dict[str, Any]:
    return {key: table.pop(key) for key in [key for key, value in table.items() if isinstance(value, dict)]}


_FORMS: dict[str, tuple[tuple[type, ...], str]] = {
    "units": ((str,), "a unit"),
    "scale": ((int, float), "a number"),
    "body": ((int,), "a whole number from 1"),
    "facets": ((bool,), "true or false"),
    "name": ((str,), "a text"),
    "material": ((str,), "a text"),
}


def _settings(table: Any, base: FileSettings, where: str, known: tuple[str, ...]) -> FileSettings:
    if not isinstance(table, dict):
        raise PalpateError(f'{where}: must be a table of settings; for example units = "mm"')
    for key, value in table.items():
        if key not in known:
            raise PalpateError(f"{where}: unknown key {key!r}; valid keys: {', '.join(known)}")
        types, form = _FORMS[key]
        if not isinstance(value, types) or (isinstance(value, bool) and bool not in types):
            raise PalpateError(f"{where}: {key} must be {form}, not {value!r}")
    made = replace(base, **table)
    try:
        checked_flags(made.units, made.scale)
    except PalpateError as error:
        raise PalpateError(f"{where}: {error}") from None
    return made
