"""The taxels of one frame in characters: colored cells with lines and arcs drawn over them.

A terminal's cell is about twice as high as wide, so a square taxel is 2k characters by k rows.  Without color the
taxels are shades of gray in characters.
"""

import numpy as np
from rich.console import Console
from rich.text import Text

from exploration.recordings.recording import Pad
from exploration.recordings.untouched import Untouched
from exploration.sensing.frame import TaxelArray
from primitives.arrays import Floats
from recognition.frames.colors import ARC, INK, LINES, PAPER, Color, heat
from recognition.frames.felt import Felt
from recognition.frames.outlines import circle, line_band

_SHADES = " .:-=+*#%@"
_SLANTS = "─╱│╲"  # a line's character by its direction, from 0 degrees on in steps of 45
_HIGHEST, _WIDEST = 30, 100  # characters


def taxel_text(felt: Felt, pad: Pad, rest: Untouched, console: Console) -> Text:
    """The picture; row 0 at the bottom."""
    across, down = _cell(pad.array, min(_WIDEST, console.width - 2))
    colored = console.color_system is not None
    above = np.where(pad.absent | ~np.isfinite(felt.counts), np.nan, felt.counts) - rest.zero
    top = max(rest.plateau, 3 * rest.noise, float(np.nanmax(above, initial=0.0)))
    over = _drawn_over(felt, pad.array, across, down)
    out = Text()
    rows, columns = pad.array.shape
    for y in range(rows * down):
        for x in range(columns * across):
            share = above[rows - 1 - y // down, x // across] / top
            mark, color = over.get((x, y), ("", INK))
            out.append(*_character(float(share), mark, color, colored))
        out.append("\n" if y < rows * down - 1 else "")
    return out


def _character(share: float, mark: str, color: Color, colored: bool) -> tuple[str, str]:
    if not colored:
        blank = " " if np.isnan(share) else _SHADES[int(np.clip(share * 9.99, 0, 9))]
        return mark or blank, ""
    if np.isnan(share):
        return mark or " ", ""
    front = PAPER if share > 0.6 and color == INK else color
    return mark or " ", f"{'bold ' if mark else ''}{_rgb(front)} on {_rgb(heat(share))}"


def _cell(array: TaxelArray, width: int) -> tuple[int, int]:
    """Characters of a taxel: across and down."""
    ratio = array.pitch[0] / array.pitch[1]
    for down in (3, 2, 1):
        across = max(1, round(2 * down * ratio))
        if array.columns * across <= width and array.rows * down <= _HIGHEST:
            return across, down
    return (2, 1) if array.columns * 2 <= width else (1, 1)


def _drawn_over(
    felt: Felt, array: TaxelArray, across: int, down: int
) -> dict[tuple[int, int], tuple[str, Color]]:
    """Characters that lines and arcs put on the taxels, by (column, row) from the top left."""
    marks: dict[tuple[int, int], tuple[str, Color]] = {}
    for arc in felt.arcs:
        _trace(circle(arc, steps=720), array, across, down, ARC, marks)
    for line, color in zip(felt.touch.lines, LINES * 4, strict=False):
        _trace(line_band(line, array, steps=400)[0], array, across, down, color, marks)
    return marks


def _trace(
    points: Floats,
    array: TaxelArray,
    across: int,
    down: int,
    color: Color,
    marks: dict[tuple[int, int], tuple[str, Color]],
) -> None:
    size = np.array(array.size)
    place = (points / size + 0.5) * np.array([array.columns * across, array.rows * down])
    place[:, 1] = array.rows * down - place[:, 1]
    steps = np.gradient(points, axis=0)
    slants = np.round(np.arctan2(steps[:, 1], steps[:, 0]) / (np.pi / 4)).astype(int) % 4
    for (x, y), slant in zip(np.floor(place).astype(int).tolist(), slants.tolist(), strict=True):
        if 0 <= x < array.columns * across and 0 <= y < array.rows * down:
            marks[x, y] = (_SLANTS[slant], color)


def _rgb(color: Color) -> str:
    return f"rgb({color[0]},{color[1]},{color[2]})"
