"""Contacts as text: x,y,z[,nx,ny,nz[,sigma]] in mm, one a line, with or without a header.

Semicolons, commas, tabs or blanks part the columns; between semicolons a comma is a decimal point; lines that
begin with # are remarks; a field left empty is not known.  With a header the columns may stand in any order, and
those with other names are passed over; it may say cm or m, as in `x [m]`.  A line that repeats another to the last
digit is the same reading, for no two scatter alike, and counts once (`places`).
"""

from __future__ import annotations

import io
import re
from pathlib import Path

import numpy as np

from primitives.arrays import Floats
from primitives.errors import PalpateError
from recognition.sources.bytes_of import bytes_of
from recognition.sources.columns import Columns

_NAMES = ("x", "y", "z", "nx", "ny", "nz", "sigma")
_FORM = "x,y,z[,nx,ny,nz[,sigma]] in mm"
_UNIT = re.compile(r"(?:[\s_]*[\[(]?(mm)|[\s_]+(cm|m)|[\s_]*[\[(](cm|m))[\])]?$")
_MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0}
_MARKS = ";,\t"


def read_table(path: Path) -> Columns:
    """The columns of a file of text."""
    try:
        text = bytes_of(path).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise PalpateError(f"{path.name} is not text; give contacts as {_FORM}") from None
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    if not lines:
        raise PalpateError(f"{path.name} holds no contact; give lines of {_FORM}")
    parted = _mark(lines[0])
    first = _fields(lines[0].replace(",", ".") if parted == ";" else lines[0], parted)
    header, scale = None, np.ones(len(first))
    if not any(_is_number(word) for word in first):
        header, lines = [_plain(word) for word in first], lines[1:]
        scale = np.array([_mm(word) for word in first])
        parted = _mark(lines[0]) if lines else parted  # a header may be parted otherwise
    if parted == ";":
        lines = [line.replace(",", ".") for line in lines]
    if not lines:
        raise PalpateError(f"{path.name} holds a header and no contact; give lines of {_FORM}")
    rows = _numbers(lines, parted, path.name, 1 if header is None else 2)
    return _named(rows * scale if rows.shape[1] == len(scale) else rows, header, path.name)


def _named(rows: Floats, header: list[str] | None, name: str) -> Columns:
    width = rows.shape[1]
    if header is None:
        if width < 3:
            raise PalpateError(f"{name} has {width} column{'s' * (width != 1)}; contacts are {_FORM}")
        normals = rows[:, 3:6] if width >= 6 else None
        return Columns(rows[:, :3], normals, rows[:, 6] if width >= 7 else None)
    at = {word: header.index(word) for word in _NAMES if word in header}
    if missing := [axis for axis in "xyz" if axis not in at]:
        raise PalpateError(f"{name} has no column {', '.join(missing)}; the columns are {_FORM}")
    if max(at.values()) >= width:
        raise PalpateError(f"{name} has more names in its header than columns; contacts are {_FORM}")
    felt = all(word in at for word in ("nx", "ny", "nz"))
    return Columns(
        rows[:, [at[axis] for axis in "xyz"]],
        rows[:, [at[word] for word in ("nx", "ny", "nz")]] if felt else None,
        rows[:, at["sigma"]] if "sigma" in at else None,
    )


def _numbers(lines: list[str], parted: str | None, name: str, start: int) -> Floats:
    if parted is not None:
        text = "\n".join(lines)
        if any(mark in text for mark in (2 * parted, parted + "\n", "\n" + parted)) or text[-1] == parted:
            lines = [parted.join(word.strip() or "nan" for word in line.split(parted)) for line in lines]
    try:
        return np.loadtxt(io.StringIO("\n".join(lines)), delimiter=parted, ndmin=2, comments=None)
    except ValueError:
        raise PalpateError(_what_is_wrong(lines, parted, name, start)) from None


def _what_is_wrong(lines: list[str], parted: str | None, name: str, start: int) -> str:
    width = len(_fields(lines[0], parted))
    for number, line in enumerate(lines, start):
        words = _fields(line, parted)
        if strange := next((word for word in words if not _is_number(word)), None):
            return f"{name}, line {number}: {strange[:20]!r} is not a number; contacts are {_FORM}"
        if len(words) != width:
            return f"{name}, line {number}: {len(words)} columns where the first has {width}; contacts are {_FORM}"
    return f"{name} is not a table of numbers; contacts are {_FORM}"


def _mark(line: str) -> str | None:
    """What parts a line; None where white space does."""
    return next((mark for mark in _MARKS if mark in line), None)


def _fields(line: str, parted: str | None) -> list[str]:
    return [word.strip() for word in line.split(parted)]


def _plain(word: str) -> str:
    return _UNIT.sub("", word.strip().strip("\"'").lower()).strip()


def _mm(word: str) -> float:
    """How many mm the unit that stands behind a name is; 1 where none does."""
    found = _UNIT.search(word.strip().strip("\"'").lower())
    return 1.0 if found is None else _MM[next(filter(None, found.groups()))]


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
