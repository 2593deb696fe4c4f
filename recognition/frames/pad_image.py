"""The taxels of one frame as an image, with the lines and arcs that were found and how sure they are.

Row 0 is at the bottom, as y points up in the sensor frame.
"""

import numpy as np
from PIL import Image, ImageDraw

from exploration.recordings.recording import Pad
from exploration.recordings.untouched import Untouched
from exploration.sensing.lines.arc import Arc
from exploration.sensing.lines.line import Line
from exploration.sensing.surfaces.local_surface import LocalSurface
from primitives.arrays import Floats
from recognition.frames.colors import ARC, LINES, PAPER, POINT, RULE, Color, heat
from recognition.frames.felt import Felt
from recognition.frames.outlines import BAND, circle, line_band, seen_part

_FAINT, _CLEAR = 70, 255  # opacity
_HATCH = 12.0  # [px] between marks on a line's material side


class PadImage:
    """Draws one frame, `scale` pixels to the mm; `thick` is the width of a line [px]."""

    def __init__(self, felt: Felt, pad: Pad, rest: Untouched, scale: float, thick: float) -> None:
        self._felt, self._pad, self._rest = felt, pad, rest
        self._scale, self._thick = scale, thick
        width, height = (max(1, round(side * scale)) for side in pad.array.size)
        self.image = Image.new("RGB", (width, height), PAPER)
        self._draw = ImageDraw.Draw(self.image, "RGBA")

    def drawn(self) -> Image.Image:
        """The whole of it."""
        self._taxels()
        for arc in self._felt.arcs:
            self._arc(arc)
        for line, color in zip(self._felt.touch.lines, LINES * 4, strict=False):
            self._line(line, color)
        self._deepest()
        return self.image

    @property
    def top(self) -> float:
        """[counts] above zero of the darkest color."""
        return max(self._rest.plateau, 3 * self._rest.noise, float(np.nanmax(self._above(), initial=0.0)))

    def _above(self) -> Floats:
        counts = np.where(self._pad.absent | ~np.isfinite(self._felt.counts), np.nan, self._felt.counts)
        return counts - self._rest.zero

    def _taxels(self) -> None:
        above, top = self._above(), self.top
        rows, columns = above.shape
        width, height = self.image.size
        gap = max(0, round(0.02 * height / rows))
        for row in range(rows):
            for column in range(columns):
                left, right = (round(width * edge / columns) for edge in (column, column + 1))
                low, high = (round(height * (rows - edge) / rows) for edge in (row + 1, row))
                box = (left, low, right - 1 - gap, high - 1 - gap)
                if np.isnan(above[row, column]):
                    self._draw.line((box[0], box[3], box[2], box[1]), fill=RULE, width=max(2, gap))
                    self._draw.line((box[0], box[1], box[2], box[3]), fill=RULE, width=max(2, gap))
                else:
                    self._draw.rectangle(box, fill=heat(float(above[row, column]) / top))

    def _line(self, line: Line, color: Color) -> None:
        points, sigma = line_band(line, self._pad.array)
        if not len(points) or np.ptp(points, axis=0).max() == 0.0:
            return
        reach = BAND * sigma[:, None] * line.normal
        band = self._px(np.concatenate([points + reach, (points - reach)[::-1]]))
        self._draw.polygon(band, fill=(*color, _FAINT))
        self._draw.line(self._px(points), fill=(*color, 150), width=round(0.5 * self._thick))
        ends = seen_part(line, self._pad.array)
        self._draw.line(self._px(ends), fill=(*color, _CLEAR), width=round(self._thick))
        count = int(np.linalg.norm(ends[1] - ends[0]) * self._scale / (_HATCH * self._thick / 3))
        for share in np.linspace(0.0, 1.0, max(2, count)):
            foot = ends[0] + share * (ends[1] - ends[0])
            tip = foot + line.inward * (2.2 * self._thick / self._scale)
            self._draw.line(
                self._px(np.stack([foot, tip])), fill=(*color, _CLEAR), width=round(0.6 * self._thick)
            )

    def _arc(self, arc: Arc) -> None:
        width = max(round(2 * BAND * arc.radius_sigma * self._scale), 1)
        self._draw.line(self._px(circle(arc)), fill=(*ARC, _FAINT), width=width, joint="curve")
        self._draw.line(
            self._px(circle(arc)), fill=(*ARC, _CLEAR), width=round(0.8 * self._thick), joint="curve"
        )
        self._cross(arc.center, np.eye(2), 2.0, ARC)

    def _deepest(self) -> None:
        """A cross where the surface is deepest, along its principal directions where it is curved."""
        surface = self._felt.touch.surface
        if not isinstance(surface, LocalSurface):
            return
        axes = surface.principal[1][:, :2] if surface.curved else np.eye(2)
        self._cross(surface.point[:2], axes, 3.6, PAPER, round(1.3 * self._thick))
        self._cross(surface.point[:2], axes, 3.2, POINT, round(0.6 * self._thick))

    def _cross(self, at: Floats, axes: Floats, size: float, color: Color, width: int = 2) -> None:
        arm = size * self._thick / self._scale
        for axis in axes:
            self._draw.line(
                self._px(np.stack([at - arm * axis, at + arm * axis])), fill=color, width=max(1, width)
            )

    def _px(self, points: Floats) -> list[tuple[float, float]]:
        """Points [mm] of the pad as pixels."""
        half = np.array(self._pad.array.size) / 2
        away = (points + half) * self._scale
        return [(float(x), float(self.image.size[1] - y)) for x, y in away]
