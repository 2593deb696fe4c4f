"""The model that `locate` is given, with what matching asks of it: made once, and kept in the user's cache.

Finding the surfaces behind a mesh takes seconds; what was found is kept under a key of the file's content and
settings in `$XDG_CACHE_HOME/palpate`, or `~/.cache/palpate`, which may be removed at any time.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from models.formats.units import Units
from models.library import Entry, Library
from models.library.build import make
from models.library.folder import ModelFile, content_key
from models.library.kept import user_cache
from models.library.packed import map_arrays
from models.library.record import text_of
from models.library.settings import FileSettings
from models.library.stored import Stored
from models.part import load_part
from primitives.errors import PalpateError


def kept_model(
    model: str, units: Units, scale: float, body: int | None = None, facets: bool = False
) -> tuple[Entry, tuple[str, ...]]:
    """One entry, and what a person should know of its file."""
    path = Path(model)
    home = user_cache()
    if not path.is_file() or home is None:
        return _read(model, units, scale, body, facets)
    file = ModelFile(path.stem, path, FileSettings(units, scale, body, facets))
    kept = home / f"{content_key(file)[0]}.npz"
    arrays = map_arrays(kept)
    if arrays is None:
        try:
            if make(file, kept)[1]:
                return _read(model, units, scale, body, facets)
        except PalpateError:
            return _read(model, units, scale, body, facets)
        arrays = map_arrays(kept)
    if arrays is None:
        return _read(model, units, scale, body, facets)
    return Entry(file.name, Stored(kept, file), path), tuple(text_of(arrays)["warnings"])


def _read(
    model: str, units: Units, scale: float, body: int | None, facets: bool
) -> tuple[Entry, tuple[str, ...]]:
    part = load_part(model, units, scale, body, facets)
    return Library.of({part.name: part.solid.placed(np.eye(4))})[part.name], part.warnings
