"""Files that appear whole or not at all."""

import os
from pathlib import Path

from primitives.errors import PalpateError


def write_whole(file: Path, data: bytes) -> None:
    """Write under a temporary name, then rename."""
    partial = file.with_name(f".{file.name}.{os.getpid()}.partial")
    try:
        partial.write_bytes(data)
        partial.replace(file)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise PalpateError(f"cannot write {file} ({error.strerror}); choose another folder") from None
