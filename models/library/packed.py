"""Arrays in one file that any numpy opens (.npz, no pickle) and that we map into memory instead of reading.

Members are stored, not compressed, and each begins on a multiple of 64 bytes: a padded field in its header sees to
that.  A file appears whole or not at all.
"""

from __future__ import annotations

import io
import mmap
import os
import struct
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from primitives.errors import NotWritten

_ALIGN = 64
_HEADER = 30  # [bytes] of a member's local header, before its name
_PAD_ID = 0x6470  # of the extra field, whose own header takes 4 bytes


def write_arrays(path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write arrays under a temporary name, then rename."""
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        with zipfile.ZipFile(partial, "w", zipfile.ZIP_STORED) as file:
            for name, array in arrays.items():
                buffer = io.BytesIO()
                npy.write_array(buffer, np.ascontiguousarray(array), allow_pickle=False)
                info = zipfile.ZipInfo(f"{name}.npy", (1980, 1, 1, 0, 0, 0))
                begin = file.fp.tell() + _HEADER + len(info.filename) + 4  # type: ignore[union-attr]
                pad = -begin % _ALIGN
                info.extra = struct.pack("<HH", _PAD_ID, pad) + bytes(pad)
                file.writestr(info, buffer.getvalue())
        partial.replace(path)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise NotWritten(
            f"cannot write {path} ({error.strerror or error}); make room, or copy the folder"
        ) from None
    except BaseException:
        partial.unlink(missing_ok=True)
        raise


def map_arrays(path: Path) -> dict[str, NDArray[Any]] | None:
    """The arrays of a file, read-only, each page read when it is first touched; None if it is no whole file."""
    try:
        with path.open("rb") as file, zipfile.ZipFile(file) as archive:
            mapped = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
            return {info.filename.removesuffix(".npy"): _mapped(mapped, info) for info in archive.infolist()}
    except (OSError, ValueError, zipfile.BadZipFile, struct.error, EOFError, NotImplementedError):
        return None


def _mapped(mapped: mmap.mmap, info: zipfile.ZipInfo) -> NDArray[Any]:
    name, extra = struct.unpack_from("<HH", mapped, info.header_offset + 26)
    begin = info.header_offset + _HEADER + name + extra
    head = io.BytesIO(mapped[begin : begin + min(info.file_size, 1024)])
    if npy.read_magic(head) != (1, 0) or info.compress_type != zipfile.ZIP_STORED:
        raise ValueError("not as we write it")
    shape, fortran, dtype = npy.read_array_header_1_0(head)
    if fortran or dtype.hasobject:
        raise ValueError("not as we write it")
    count = int(np.prod(shape, dtype=np.int64))
    if head.tell() + count * dtype.itemsize > info.file_size:
        raise ValueError("too short")
    return np.frombuffer(mapped, dtype, count, begin + head.tell()).reshape(shape)
