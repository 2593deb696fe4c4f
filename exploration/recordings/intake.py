"""Files as they come in: there, whole, readable, and what their name says.

Every outside file is opened here, so what is wrong with one is said the same way for all formats.
"""

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from primitives.errors import PalpateError

LARGEST = 1 << 30  # [bytes] that a compressed file may inflate to

_MAGIC = {
    b"\x93NUMPY": ".npy",
    b"PK\x03\x04": ".npz",
    b"PK\x05\x06": ".npz",
    b"BZh": ".dsa",
    b"<?xml": ".dsa",
    b"\x89MCAP0": ".mcap",
}


@contextmanager
def opened(path: Path) -> Iterator[BinaryIO]:
    """A recording's bytes; what cannot be read is a `PalpateError`."""
    try:
        with open(path, "rb", opener=_without_waiting) as file:
            mode = os.fstat(file.fileno()).st_mode
            if stat.S_ISDIR(mode):
                raise IsADirectoryError
            if not stat.S_ISREG(mode):
                raise PalpateError(f"{path} is a device or a pipe; give a file")
            yield file
    except FileNotFoundError:
        raise PalpateError(f"no file {path}; check the path") from None
    except IsADirectoryError:
        raise PalpateError(f"{path} is a folder; name a file in it{_hint(path)}") from None
    except PermissionError:
        raise PalpateError(f"{path} may not be read; give yourself the permission: chmod u+r") from None
    except OSError as error:
        raise PalpateError(f"cannot read {path}: {error.strerror or error}") from error


def refuse_other_content(path: Path, suffix: str) -> None:
    """Refuse an empty file, and one whose first bytes belong to another format than its name."""
    with opened(path) as file:
        start = file.read(8)
    if not start:
        raise PalpateError(f"{path} is empty; record or copy it again")
    found = next((kind for magic, kind in _MAGIC.items() if start.startswith(magic)), None)
    if found and found != suffix:
        raise PalpateError(f"{path} holds what a {found} file holds; rename it to {path.stem}{found}")


def inflated_too_far(path: Path) -> PalpateError:
    """What to raise when a file inflates past `LARGEST`."""
    return PalpateError(f"{path} inflates past {LARGEST >> 30} GB; record in shorter pieces, or write .npy")


def _hint(path: Path) -> str:
    episode = path / "episode.mcap"
    return f", such as {episode}" if episode.is_file() else ""


def _without_waiting(name: str, flags: int) -> int:
    return os.open(name, flags | getattr(os, "O_NONBLOCK", 0))
