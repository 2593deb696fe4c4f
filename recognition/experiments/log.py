"""The rows of a suite as they come, one JSON object a line, only ever appended to.

A kill leaves at most one line that is not whole, the last, which is cut off before more is written.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from types import TracebackType

from primitives.errors import NotWritten
from recognition.experiments.trial import Row

PATTERN = "trials*.jsonl"


class Log:
    """One file of rows, open to be appended to; a context manager."""

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            _mend(path)
            self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
        except OSError as error:
            raise _not_written(path, error) from error

    def append(self, row: Row) -> None:
        """Write a row, whole or not at all."""
        line = (json.dumps(row, ensure_ascii=False) + "\n").encode()
        try:
            before = os.fstat(self._file).st_size
            if os.write(self._file, line) != len(line):
                os.ftruncate(self._file, before)
                raise OSError(28, "No space left on device")
        except OSError as error:
            raise _not_written(self._path, error) from error

    def __enter__(self) -> Log:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with suppress(OSError):
            os.fsync(self._file)
        os.close(self._file)


def rows_of(folders: Iterable[Path]) -> dict[int, Row]:
    """Every whole row of some folders, by trial; of a trial told twice, the first."""
    out: dict[int, Row] = {}
    for folder in folders:
        for path in sorted(folder.glob(PATTERN)):
            for line in path.read_bytes().split(b"\n")[:-1]:
                with suppress(ValueError):
                    row: Row = json.loads(line)
                    number = row["trial"]
                    assert isinstance(number, int)
                    out.setdefault(number, row)
    return dict(sorted(out.items()))


def _mend(path: Path) -> None:
    """Cut a line off that is not whole."""
    if not path.exists():
        return
    data = path.read_bytes()
    whole = data.rfind(b"\n") + 1
    if whole < len(data):
        os.truncate(path, whole)


def _not_written(path: Path, error: OSError) -> NotWritten:
    return NotWritten(
        f"cannot write {path} ({error.strerror or error}); make room, and go on with --resume: nothing is repeated"
    )
