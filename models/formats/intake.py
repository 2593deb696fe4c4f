"""A file's bytes, or one line that says why not: what is checked before any parser sees them.

Counts in a header are held against the bytes that follow, so that a short file cannot ask for much memory.
"""

import json
import os
import re
import struct
from collections.abc import Callable
from pathlib import Path

from primitives.errors import PalpateError

DRAWINGS = (".csg", ".scad")
SUFFIXES = (".stl", ".obj", ".ply", ".off", ".glb", ".gltf", ".3mf", ".step", ".stp", *DRAWINGS)
_ALIASES = {".stp": ".step"}
LARGEST = 500_000_000  # [bytes] of a file that is read
MOST_TRIANGLES = 1_000_000
_ASCII = bytes(range(128)) + b"?" * 128
_PLY_SIZES = {
    **dict.fromkeys(("char", "uchar", "int8", "uint8"), 1),
    **dict.fromkeys(("short", "ushort", "int16", "uint16"), 2),
    **dict.fromkeys(("int", "uint", "int32", "uint32", "float", "float32"), 4),
    **dict.fromkeys(("double", "float64", "int64", "uint64"), 8),
}


def looks_like_a_file(text: str) -> bool:
    """Whether a name is that of a file, and not of something built in."""
    return bool(Path(text).suffix) or os.sep in text


def require_file(path: Path) -> None:
    """Refuse what is no regular file of sensible size; costs no parser's import."""
    name = path.name or str(path)
    if path.is_symlink() and not path.exists():
        raise PalpateError(f"{name} is a link to {os.readlink(path)}, which is gone; give the file itself")
    if path.is_dir():
        raise PalpateError(f"{name} is a folder; give one of the files in it")
    if not path.exists():
        raise PalpateError(f"no file {path}; check the path")
    if not path.is_file():
        raise PalpateError(f"{name} is not a regular file; copy its content to one")
    if path.stat().st_size > LARGEST:
        raise PalpateError(f"{name} has more than {LARGEST // 10**6} MB; reduce its triangles first")


def read(path: Path) -> bytes:
    """All bytes of a regular file of sensible size that is not blank."""
    require_file(path)
    name = path.name
    try:
        data = path.read_bytes()
    except PermissionError:
        raise PalpateError(f"{name} may not be read; change its permissions (chmod +r)") from None
    except OSError as error:
        raise PalpateError(
            f"{name} cannot be read ({error.strerror}); copy it somewhere else first"
        ) from None
    if not data:
        raise PalpateError(f"{name} is empty; export it again")
    if not data[:4096].strip() and not data.strip():
        raise PalpateError(f"{name} holds only blanks; export it again")
    return data


def glance(path: Path) -> None:
    """Refuse what its name, size and first bytes show to be unreadable, before anything heavy is loaded."""
    suffix = path.suffix.lower()
    require_file(path)
    if suffix not in SUFFIXES:
        known = " ".join(SUFFIXES)
        raise PalpateError(f"cannot read {path.name}: {suffix or 'no'} extension; use one of {known}")
    data = read(path)
    if suffix not in DRAWINGS:
        checked(data, suffix, path.name)


def check_triangles(count: int, name: str) -> None:
    """Refuse more triangles than can be handled in bounded memory and time."""
    if count > MOST_TRIANGLES:
        raise PalpateError(
            f"{name} has {count:,} triangles, more than {MOST_TRIANGLES:,}; reduce them in a mesh editor first"
        )


_NOT_CAD = (  # what comes in place of a file, by its first bytes in lower case
    (b"version https://git-lfs", "a pointer of Git LFS", "fetch the file that it stands for (git lfs pull)"),
    (b"<!doctype html", "a web page", "download the file itself"),
    (b"<html", "a web page", "download the file itself"),
)
_PACKED = (b"\x1f\x8b", b"PK\x03\x04", b"7z\xbc\xaf", b"Rar!", b"BZh", b"\xfd7zXZ")


def checked(data: bytes, suffix: str, name: str) -> bytes:
    """The bytes, if they are what the suffix says and as many as their header says."""
    for mark, what, cure in _NOT_CAD:
        if data[:256].lstrip(b"\xef\xbb\xbf \r\n\t").lower().startswith(mark):
            raise PalpateError(f"{name} is {what} inside; {cure}")
    found = _sniff(data)
    if found not in (None, suffix, _ALIASES.get(suffix)):
        raise PalpateError(f"{name} is {found[1:].upper()} inside; rename it to end in {found}")
    if suffix != ".3mf" and data.startswith(_PACKED):
        raise PalpateError(f"{name} is a packed archive inside; unpack it first")
    return _CHECKS.get(suffix, _text)(data, name)


def _sniff(data: bytes) -> str | None:
    head = data[:512].lstrip()
    if head.startswith(b"glTF"):
        return ".glb"
    if re.match(rb"ply\s", head):
        return ".ply"
    if re.match(rb"(ST)?(C)?(N)?OFF\b", head):
        return ".off"
    if re.match(rb"solid\b.*?\bfacet\b", data[:4096].lstrip(), re.DOTALL | re.IGNORECASE):
        return ".stl"
    if head.startswith(b"ISO-10303-21"):
        return ".step"
    if head.startswith(b"PK\x03\x04") and b"3D/" in data:
        return ".3mf"
    return None


def _stl(data: bytes, name: str) -> bytes:
    if _is_text(data) and data.lstrip()[:5].lower() == b"solid":
        data = _plain(data).lower()
        if not data.rstrip().rsplit(b"\n", 1)[-1].lstrip().startswith(b"endsolid"):
            raise PalpateError(f"{name} ends in the middle (no endsolid); it is truncated: export it again")
        check_triangles(data.count(b"endfacet"), name)
        return data
    if _is_text(data):
        raise PalpateError(f"{name} is text but not STL; export it again")
    if len(data) < 84:
        raise PalpateError(f"{name} is too short for STL; export it again")
    count = struct.unpack_from("<I", data, 80)[0]
    held = (len(data) - 84) // 50
    if count > held:
        raise PalpateError(
            f"{name} announces {count} triangles and holds {held}; it is truncated: export it again"
        )
    check_triangles(count, name)
    return data[: 84 + 50 * count]


def _ply(data: bytes, name: str) -> bytes:
    header, mark, _ = data[:65536].partition(b"end_header")
    if not header.startswith(b"ply") or not mark:
        raise PalpateError(f"{name} has no complete PLY header; export it again")
    binary, need, size, count = b"format ascii" not in header, 0, 0, 0
    for line in [*header.decode("ascii", "replace").splitlines(), "element end 0"]:
        words = line.split()
        if words[:1] == ["element"] and len(words) == 3:
            need += count * (size if binary else 2)
            count, size = (int(words[2]) if words[2].isdecimal() else 0), 0
        elif words[:1] == ["property"] and len(words) >= 3:
            size += _PLY_SIZES.get(words[2] if words[1] == "list" else words[1], 1)
    held = len(data) - len(header) - len(mark)
    if need > held:
        raise PalpateError(
            f"{name} announces {need} bytes and holds {held}; it is truncated: export it again"
        )
    return header.translate(_ASCII) + data[len(header) :]


def _glb(data: bytes, name: str) -> bytes:
    broken = PalpateError(f"{name} is not a whole GLB file; export it again")
    if len(data) < 20 or data[:4] != b"glTF" or struct.unpack_from("<I", data, 8)[0] > len(data):
        raise broken
    try:
        tree = json.loads(data[20 : 20 + struct.unpack_from("<I", data, 12)[0]])
        counts = [int(accessor["count"]) for accessor in tree.get("accessors", [])]
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise broken from None
    if sum(counts) > len(data) or min(counts, default=0) < 0:
        raise PalpateError(f"{name} announces more data than it holds; it is truncated: export it again")
    return data


def _zip(data: bytes, name: str) -> bytes:
    if not data.startswith(b"PK"):
        raise PalpateError(f"{name} is not a 3MF archive; export it again")
    return data


def _step(data: bytes, name: str) -> bytes:
    if not _text(data, name).lstrip(b"\xef\xbb\xbf \r\n\t").startswith((b"ISO-10303-21", b"/*")):
        raise PalpateError(f"{name} does not begin with ISO-10303-21, so it is not STEP; export it again")
    return data


def _obj(data: bytes, name: str) -> bytes:
    data = _plain(_text(data, name))
    check_triangles(data.count(b"\nf ") + data.count(b"\nf\t"), name)
    return data


def _text(data: bytes, name: str) -> bytes:
    if not _is_text(data):
        raise PalpateError(f"{name} is binary where text should be; export it again")
    return data


def _plain(data: bytes) -> bytes:
    """The text in ASCII, its lines ended by line feeds; names, which may be in any code, are not kept."""
    return data.translate(_ASCII).replace(b"\r\n", b"\n").replace(b"\r", b"\n")


def _truncated(name: str, wanted: str, held: int) -> PalpateError:
    return PalpateError(f"{name} announces {wanted} and holds {held}; it is truncated: export it again")


def _is_text(data: bytes) -> bool:
    sample = data[:4096]
    return b"\0" not in sample and sum(byte > 126 or byte < 9 for byte in sample) * 10 <= len(sample)


_CHECKS: dict[str, Callable[[bytes, str], bytes]] = {
    ".stl": _stl,
    ".obj": _obj,
    ".ply": _ply,
    ".off": _text,
    ".glb": _glb,
    ".3mf": _zip,
    ".step": _step,
    ".stp": _step,
}
