"""A fault of Palpate's own: one line that says so, and a file with what its makers need."""

from __future__ import annotations

import platform
import sys
import tempfile
import traceback
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path

from primitives.errors import PalpateError

BUG = "bug.txt"


class Bug(PalpateError):
    """Something that should not have happened."""


def report_text(error: BaseException) -> str:
    """The traceback, and on what it happened."""
    where = f"palpate {version('palpate')}, Python {platform.python_version()}, {platform.platform()}"
    return f"{where}\n{' '.join(sys.argv)}\n\n{''.join(traceback.format_exception(error))}"


def named(error: BaseException) -> str:
    """The error as one line."""
    text = str(error).strip()
    return f"{type(error).__name__}: {text.splitlines()[0]}" if text else type(error).__name__


def told(error: BaseException, folder: Path | None = None) -> Bug:
    """The one line, after the details were written to the folder of the run, or to a temporary file."""
    place = folder / BUG if folder else Path(tempfile.gettempdir()) / f"palpate-{BUG}"
    where = "its details could not be written"
    with suppress(OSError):
        place.write_text(report_text(error), encoding="utf-8")
        where = f"please report it with {place}"
    return Bug(f"this is a bug in palpate, not in what it was given ({named(error)}); {where}")
