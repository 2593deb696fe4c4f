"""A source file's bytes, or the one line that says why there are none."""

from __future__ import annotations

from pathlib import Path

from exploration.recordings.intake import opened
from primitives.errors import PalpateError

LARGEST = 1_000_000_000  # [bytes] that are read at once


def bytes_of(path: Path) -> bytes:
    """All of a file that is there, not empty, and of sensible size."""
    with opened(path) as file:
        data = file.read(LARGEST + 1)
    if not data.strip():
        raise PalpateError(f"{path} is empty; export it again")
    if len(data) > LARGEST:
        raise PalpateError(f"{path} has more than {LARGEST // 10**9} GB; give a part of its contacts")
    return data
