"""`.csv` stacks of any array: frames as blocks of lines, or one frame a line with an optional time before it.

Numbers are separated by commas, semicolons, tabs or spaces.  Blocks of `rows` lines, parted by blank lines or
`#` comments, are frames; a single block is one frame a line, or one frame where its shape says so (`layout`).
With a header, columns called time (`time`, `t`, `time_s`, `time_ms`, `timestamp`, ...) and index (`frame`,
`index`) are known by their names; without one, a column too many before the taxels is the time in seconds.  An
empty cell is a missing value.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from exploration.recordings.intake import opened
from exploration.recordings.layout import layout_of, plain_warnings, preset_shapes
from exploration.recordings.recording import PadFrame, Recording
from exploration.sensing.frame import TaxelFrame
from exploration.sensing.spec import SensorSpec
from primitives.arrays import frozen
from primitives.errors import PalpateError

TIMES = {
    "time": 1.0,
    "t": 1.0,
    "time_s": 1.0,
    "timestamp": 1.0,
    "seconds": 1.0,
    "time_ms": 1e-3,
    "timestamp_ms": 1e-3,
}
INDICES = ("frame", "index", "frame_index", "i")
_LONGEST_LINE = 1 << 22  # [bytes]
_EPOCH_MS = 1e11  # a time stamp beyond it counts milliseconds since 1970


@dataclass(frozen=True)
class _Plan:
    """How the lines make frames."""

    header: tuple[str, ...]  # names of the columns; empty without a header
    columns: int
    blocks: int
    lines: int  # of each block
    begins: tuple[float, float]  # first and last value of the first column
    rising: bool  # whether the first column never falls


def read_csv(path: Path, spec: SensorSpec | None = None) -> Recording:
    """A stack in a .csv file."""
    plan = _plan(path)
    skip, time_at, scale = _leading(plan, spec)
    taxels = plan.columns - skip
    stacked = plan.blocks > 1
    shape = (plan.blocks, plan.lines, taxels) if stacked else (plan.lines, taxels)
    if spec is not None and not stacked and taxels == spec.array.columns and not plan.lines % spec.array.rows:
        shape = (plan.lines // spec.array.rows, spec.array.rows, taxels)
    layout = layout_of(str(path), shape, spec)
    timed = time_at is not None
    if timed and layout.frames != plan.lines:
        raise PalpateError(f"{path}: a time column needs one frame a line; leave it out of blocks of lines")
    if timed and scale == 1.0 and plan.begins[0] > _EPOCH_MS:
        scale = 1e-3

    def replay() -> Iterator[PadFrame]:
        need = plan.blocks * plan.lines // layout.frames
        held: list[list[float]] = []
        index, first = 0, None
        for _, values in _rows(path, bool(plan.header)):
            if values is None:
                continue
            held.append(values)
            if len(held) == need:
                time = np.nan
                if time_at is not None:
                    first = held[0][time_at] if first is None else first
                    time = (held[0][time_at] - first) * scale
                counts = np.array(held)[:, skip:].reshape(layout.shape[2:])
                yield PadFrame(0, TaxelFrame(frozen(counts), time, index))
                held, index = [], index + 1

    pad = layout.pads[0]
    return Recording(
        path=path,
        sensor=pad.array.name,
        pads=layout.pads,
        replay=replay,
        timed=timed,
        posed=False,
        warnings=(*layout.assumed, *plain_warnings(layout.pads, timed, posed=False)),
    )


def _leading(plan: _Plan, spec: SensorSpec | None) -> tuple[int, int | None, float]:
    """Columns before the taxels, which of them is the time, and its unit [s]."""
    skip = 0
    time_at, scale = None, 1.0
    while skip < min(2, len(plan.header)) and plan.header[skip] in (*TIMES, *INDICES):
        if plan.header[skip] in TIMES and time_at is None:
            time_at, scale = skip, TIMES[plan.header[skip]]
        skip += 1
    if skip or plan.header or plan.blocks > 1 or not plan.rising:
        return skip, time_at, scale
    one_more = plan.columns - 1
    if spec is not None:
        extra = one_more == spec.array.rows * spec.array.columns
    else:
        extra = plan.lines > 2 and bool(preset_shapes(one_more)) and not preset_shapes(plan.columns)
    return (1, 0, 1.0) if extra else (0, None, 1.0)


def _plan(path: Path) -> _Plan:
    """Go through the file once: its blocks, and what is ragged."""
    header: tuple[str, ...] = ()
    columns, blocks, lines, here = 0, 0, 0, 0
    begins, last, rising = np.nan, np.nan, True
    for number, cells in _cells(path):
        if cells is None:
            if here:
                blocks, lines, here = _closed(path, number, blocks, lines, here)
            continue
        if not columns and not header and not _numeric(cells):
            header, columns = tuple(cell.strip().strip("\"'").lower() for cell in cells), len(cells)
            continue
        columns = columns or len(cells)
        if len(cells) != columns:
            raise PalpateError(
                f"{path}: line {number} has {len(cells)} values where others have {columns}; even it out"
            )
        value = _value(path, number, cells[0])
        rising = rising and not value < last
        begins, last = (value if np.isnan(begins) else begins), value
        here += 1
    if here:
        blocks, lines, _ = _closed(path, 0, blocks, lines, here)
    if not blocks:
        raise PalpateError(
            f"{path} holds no line of numbers; give one frame a line, or frames parted by blank lines"
        )
    return _Plan(header, columns, blocks, lines, (begins, last), rising)


def _closed(path: Path, number: int, blocks: int, lines: int, here: int) -> tuple[int, int, int]:
    """Count a block that has ended."""
    if blocks and here != lines:
        place = f"before line {number}" if number else "at the end"
        raise PalpateError(
            f"{path}: the block {place} has {here} lines where others have {lines}; even it out"
        )
    return blocks + 1, here, 0


def _rows(path: Path, has_header: bool) -> Iterator[tuple[int, list[float] | None]]:
    """Numbers line by line, None between blocks."""
    for number, cells in _cells(path):
        if cells is not None and has_header:
            has_header = False
            continue
        yield number, None if cells is None else [_value(path, number, cell) for cell in cells]


def _cells(path: Path) -> Iterator[tuple[int, list[str] | None]]:
    """Texts line by line with the line's number, None where blocks are parted."""
    separator: str | None = ""
    with opened(path) as file:
        number = 0
        while line := file.readline(_LONGEST_LINE + 1):
            number += 1
            if len(line) > _LONGEST_LINE:
                raise PalpateError(
                    f"{path}: line {number} is longer than {_LONGEST_LINE >> 20} MB; one frame a line"
                )
            try:
                text = line.decode("utf-8-sig" if number == 1 else "utf-8").strip()
            except UnicodeDecodeError:
                raise PalpateError(
                    f"{path}: line {number} is not text; give numbers parted by commas"
                ) from None
            if not text or text.startswith("#"):
                yield number, None
                continue
            if separator == "":
                separator = next((mark for mark in ",;\t" if mark in text), None)
            yield number, (re.split(r"\s+", text) if separator is None else text.split(separator))


def _numeric(cells: list[str]) -> bool:
    return all(_is_number(cell) for cell in cells)


def _is_number(cell: str) -> bool:
    try:
        float(cell.strip() or "nan")
    except ValueError:
        return False
    return True


def _value(path: Path, number: int, cell: str) -> float:
    try:
        return float(cell.strip() or "nan")
    except ValueError:
        raise PalpateError(
            f"{path}: line {number} holds {cell.strip()[:40]!r}, not a number; take it out"
        ) from None
