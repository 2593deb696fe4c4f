"""One frame of one pad as a PNG: its taxels beside kinds, lines and numbers.

Drawn larger and shrunk, which smooths every edge.
"""

from __future__ import annotations

from functools import lru_cache
from math import isfinite
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from exploration.recordings.recording import Pad
from exploration.recordings.untouched import Untouched
from primitives.errors import PalpateError
from recognition.frames.colors import ARC, INK, KINDS, LINES, PAPER, RULE, SOFT, Color, heat
from recognition.frames.felt import Felt
from recognition.frames.pad_image import PadImage
from recognition.frames.words import arc_words, curvature_words, force_words, line_words, unit_of, verdict

_ZOOM = 2  # drawn so many times larger
_LARGEST = 440  # [px] of the pad's longer side
_NARROWEST = 190  # [px] left for the pad
_PANEL = 330  # [px] of the numbers beside it
_MARGIN = 28  # [px]
_AXIS = 34  # [px] left of the pad and below it
_TITLE = 58  # [px]
_ROW = 22  # [px]


def write_picture(folder: Path, felt: Felt, pad: Pad, rest: Untouched) -> str:
    """Write it whole or not at all; its name in the folder."""
    name = f"frame-{felt.index:06d}-pad{felt.pad}.png"
    partial = folder / f".{name}.partial"
    try:
        draw_picture(felt, pad, rest).save(partial, "png")
        partial.replace(folder / name)
    except OSError as error:
        raise PalpateError(f"cannot write {folder / name}: {error.strerror or error}") from error
    finally:
        partial.unlink(missing_ok=True)
    return name


def draw_picture(felt: Felt, pad: Pad, rest: Untouched) -> Image.Image:
    """The picture."""
    scale = _LARGEST / max(pad.array.size)  # [px/mm]
    image = PadImage(felt, pad, rest, scale * _ZOOM, 3.0 * _ZOOM)
    taxels = image.drawn()
    width, height = (side // _ZOOM for side in taxels.size)
    rows = 12 + 2 * len(felt.touch.lines) + len(felt.arcs)
    left, top = _MARGIN + _AXIS, _MARGIN + _TITLE
    panel = left + max(width, _NARROWEST) + _MARGIN
    sheet = _Sheet(panel + _PANEL + _MARGIN, top + max(height + _AXIS + 40, rows * _ROW) + _MARGIN)
    sheet.paste(taxels, left, top)
    _head(sheet, felt, pad)
    _axes(sheet, pad, (left, top, width, height))
    _ramp(sheet, (left, top + height + _AXIS, width), image.top)
    _numbers(sheet, felt, pad, panel, top)
    return sheet.shrunk()


class _Sheet:
    """Paper that is measured in final pixels."""

    def __init__(self, width: int, height: int) -> None:
        self._image = Image.new("RGB", (width * _ZOOM, height * _ZOOM), PAPER)
        self._draw = ImageDraw.Draw(self._image)
        self.width = width

    def paste(self, image: Image.Image, x: int, y: int) -> None:
        self._image.paste(image, (x * _ZOOM, y * _ZOOM))

    def text(
        self, x: float, y: float, words: str, size: int = 13, color: Color = INK, at: str = "lm"
    ) -> None:
        self._draw.text((x * _ZOOM, y * _ZOOM), words, color, _font(size * _ZOOM), anchor=at)

    def line(
        self, x0: float, y0: float, x1: float, y1: float, color: Color = RULE, width: float = 1.0
    ) -> None:
        ends = (x0 * _ZOOM, y0 * _ZOOM, x1 * _ZOOM, y1 * _ZOOM)
        self._draw.line(ends, color, round(width * _ZOOM))

    def box(self, x: float, y: float, width: float, height: float, color: Color) -> None:
        corners = (x * _ZOOM, y * _ZOOM, (x + max(width, 1)) * _ZOOM, (y + height) * _ZOOM)
        self._draw.rounded_rectangle(corners, 2 * _ZOOM, color)

    def shrunk(self) -> Image.Image:
        return self._image.reduce(_ZOOM)


def _head(sheet: _Sheet, felt: Felt, pad: Pad) -> None:
    when = f"{felt.time:.3f} s" if isfinite(felt.time) else "no time"
    sheet.text(_MARGIN, _MARGIN + 8, f"frame {felt.index}, pad {felt.pad}", 20)
    sheet.text(_MARGIN, _MARGIN + 33, f"{pad.array.name}, {when}", 13, SOFT)
    color = KINDS[felt.touch.kind]
    words = verdict(felt)
    sheet.text(sheet.width - _MARGIN, _MARGIN + 8, words, 20, color, "rm")
    sheet.line(_MARGIN, _MARGIN + 48, sheet.width - _MARGIN, _MARGIN + 48)


def _axes(sheet: _Sheet, pad: Pad, box: tuple[int, int, int, int]) -> None:
    """Ticks in mm from the pad's center."""
    left, top, width, height = box
    size_x, size_y = pad.array.size
    step = next((s for s in (0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500) if max(size_x, size_y) / s <= 10), 1000)
    for i in range(-int(size_x / 2 / step), int(size_x / 2 / step) + 1):
        x = left + (i * step / size_x + 0.5) * width
        sheet.line(x, top + height + 2, x, top + height + 6, SOFT)
        sheet.text(x, top + height + 14, f"{i * step:g}", 11, SOFT, "mm")
    for i in range(-int(size_y / 2 / step), int(size_y / 2 / step) + 1):
        y = top + (0.5 - i * step / size_y) * height
        sheet.line(left - 6, y, left - 2, y, SOFT)
        sheet.text(left - 9, y, f"{i * step:g}", 11, SOFT, "rm")
    sheet.text(left - 9, top + height + 14, unit_of(pad), 11, SOFT, "rm")


def _ramp(sheet: _Sheet, box: tuple[int, int, int], top: float) -> None:
    """The colors' counts."""
    left, y, width = box
    for i in range(width):
        sheet.line(left + i, y, left + i, y + 8, heat(i / max(1, width - 1)), 1.5)
    sheet.text(left, y + 18, "0", 11, SOFT, "lm")
    sheet.text(left + width, y + 18, f"{top:.0f} counts", 11, SOFT, "rm")


def _numbers(sheet: _Sheet, felt: Felt, pad: Pad, x: int, y: int) -> None:
    """Kinds as bars, then lines, arcs, curvature and force."""
    unit = unit_of(pad)
    right = sheet.width - _MARGIN
    bar = x + 70
    for kind, color in KINDS.items():
        share = felt.touch.kinds[kind]
        sheet.text(x, y + 7, kind, 13, INK if kind == felt.touch.kind else SOFT)
        sheet.box(bar, y + 1, right - 48 - bar, 12, RULE)
        sheet.box(bar, y + 1, (right - 48 - bar) * share, 12, color)
        sheet.text(right, y + 7, f"{100 * share:.1f} %", 12, SOFT, "rm")
        y += _ROW
    y += _ROW // 2
    for line, color in zip(felt.touch.lines, LINES * 4, strict=False):
        angle, offset, length = line_words(line, unit)
        sheet.box(x, y + 2, 10, 10, color)
        sheet.text(x + 18, y + 7, f"line at {angle}, {length} seen")
        sheet.text(x + 18, y + 7 + _ROW, f"offset {offset}", 13, SOFT)
        y += 2 * _ROW
    for arc in felt.arcs:
        sheet.box(x, y + 2, 10, 10, ARC)
        sheet.text(x + 18, y + 7, arc_words(arc, unit))
        y += _ROW
    if not felt.touch.lines and not felt.arcs:
        sheet.text(x, y + 7, "no line, no arc", 13, SOFT)
        y += _ROW
    for name, words in (("curvature", curvature_words(felt, pad)), ("force", force_words(felt, pad))):
        sheet.text(x, y + 7, name, 13, SOFT)
        sheet.text(bar + 8, y + 7, words)
        y += _ROW


@lru_cache(maxsize=8)
def _font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(size)
