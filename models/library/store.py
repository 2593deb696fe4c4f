"""Where a library keeps what it made: `.palpate` beside the files, or nowhere where that may not be written.

    .palpate/index.json        what there is, written last; without it the library was never built to its end
    .palpate/KEY.npz           one object, named by the key of its content and settings

Objects and index are renamed into place, so a kill leaves whole files only; what was made until then is found
again by its key.  A lock lets one builder work at a time; it ends with the process that
holds it, however that ends.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from models.library.folder import VERSION, Stamp
from primitives.errors import NotWritten

try:
    import fcntl
except ImportError:
    fcntl = None  # type: ignore[assignment]

HOME = ".palpate"


@dataclass(frozen=True)
class Row:
    """What the index says of one object, or of a file that made none."""

    name: str
    file: str  # in the folder
    key: str
    stamps: dict[str, Stamp]  # of all that it was made from
    settings: dict[str, Any]
    about: dict[str, Any]  # faces, extent_mm, volume_mm3, area_mm2, symmetry; none where it failed
    failed: str = ""  # why there is no object


class Store:
    """The folder `.palpate`."""

    def __init__(self, folder: Path) -> None:
        self.home = folder / HOME

    def entry(self, key: str) -> Path:
        """Where an object is."""
        return self.home / f"{key}.npz"

    def writable(self) -> bool:
        """Whether something may be written, after making the folder."""
        with suppress(OSError):
            self.home.mkdir(exist_ok=True)
            return os.access(self.home, os.W_OK)
        return False

    def load(self) -> tuple[Row, ...] | None:
        """The index; None if there is none, or none that this version can read."""
        try:
            told = json.loads((self.home / "index.json").read_text(encoding="utf-8"))
            if told["version"] != VERSION:
                return None
            return tuple(
                Row(**(row | {"stamps": {f: (s[0], s[1]) for f, s in row["stamps"].items()}}))
                for row in told["rows"]
            )
        except (OSError, ValueError, KeyError, TypeError, AttributeError, IndexError, RecursionError):
            return None

    def save(self, rows: tuple[Row, ...]) -> None:
        """Replace the index."""
        text = json.dumps({"version": VERSION, "rows": [vars(row) for row in rows]}, separators=(",", ":"))
        path = self.home / "index.json"
        partial = self.home / f".index.{os.getpid()}.partial"
        try:
            partial.write_text(text, encoding="utf-8")
            partial.replace(path)
        except OSError as error:
            partial.unlink(missing_ok=True)
            raise NotWritten(
                f"cannot write {path} ({error.strerror}); make room, or copy the folder"
            ) from None

    def sweep(self, rows: tuple[Row, ...]) -> None:
        """Remove objects that no row names, and what killed builders left; only under the lock."""
        kept = {f"{row.key}.npz" for row in rows}
        for path in self.home.iterdir():
            if (path.suffix == ".npz" and path.name not in kept) or path.suffix == ".partial":
                path.unlink(missing_ok=True)

    @contextmanager
    def locked(self, waiting: Callable[[], object]) -> Iterator[None]:
        """Alone among builders; `waiting` is called if another one has to end first."""
        if fcntl is None:
            yield
            return
        with (self.home / "lock").open("a") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                waiting()
                fcntl.flock(lock, fcntl.LOCK_EX)
            yield
