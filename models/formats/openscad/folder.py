"""`use` and `include` within the file's own folder, links followed; nothing outside it is opened."""

from __future__ import annotations

from pathlib import Path

from models.formats import intake
from models.formats.openscad import syntax
from models.formats.openscad.limits import Budget
from models.formats.openscad.syntax import Source
from primitives.errors import PalpateError


class Folder:
    """The folder of the file that is read, and what has been read from it."""

    def __init__(self, home: Path | None) -> None:
        self._home = None if home is None else home.resolve()
        self._parsed: dict[Path, Source] = {}

    def find(self, wanted: str, file: Path, chain: tuple[Path, ...], budget: Budget) -> Path:
        """The file that a path named in `file` stands for, if it is in the folder."""
        shown = " ".join(wanted.split())[:60]
        if self._home is None:
            raise budget.error(f"<{shown}> is another file; save this text as a file beside it")
        try:
            found = (file.parent / wanted).resolve()
        except (OSError, ValueError, RuntimeError):
            raise budget.error(f"<{shown}> is no path; correct it") from None
        if not found.is_relative_to(self._home):
            raise budget.error(f"<{shown}> is outside the file's folder; copy it there")
        if not found.is_file():
            raise budget.error(f"no file <{shown}> in the file's folder; copy it there")
        if found in {path.resolve() for path in chain}:
            raise budget.error(f"<{shown}> includes itself; end the circle")
        return found

    def read(self, file: Path, budget: Budget) -> Source:
        """The parsed file."""
        budget.files += 1
        if budget.files > budget.limits.files:
            raise budget.error(f"more than {budget.limits.files} files are included; include fewer")
        if file not in self._parsed:
            self._parsed[file] = syntax.parse(decoded(intake.read(file), file.name), file.name)
        return self._parsed[file]


def decoded(data: bytes, name: str) -> str:
    """Text of a file, which must be UTF-8 and hold no binary zeros."""
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise PalpateError(f"{name}, line {line}: not text in UTF-8; save it as UTF-8") from None
    if "\0" in text:
        raise PalpateError(f"{name} holds binary zeros, so it is no OpenSCAD text; export it again")
    return text
