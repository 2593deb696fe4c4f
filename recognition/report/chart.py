"""Charts of estimates with their intervals as inline SVG, in the page's own colors; no script.

A chart is for looking; every number in it stands in a table beside it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

COLORS = 6  # --name-0 to --name-5
_LEFT, _RIGHT, _TOP, _BOTTOM = 52.0, 14.0, 14.0, 40.0


@dataclass(frozen=True)
class Point:
    """One estimate."""

    x: float
    y: float
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True)
class Series:
    """Estimates that belong together."""

    name: str
    points: Sequence[Point]
    color: int = 0  # of --name-0 to --name-5


@dataclass(frozen=True)
class Frame:
    """What both axes mean; a range that is not given is that of the points, within what y may be."""

    title: str
    x: str
    y: str
    x_range: tuple[float, float] | None = None
    y_range: tuple[float, float] | None = None
    y_bounds: tuple[float, float] = (-math.inf, math.inf)
    diagonal: bool = False  # the line on which y is x
    steps: bool = False  # whether a value holds until the next
    width: float = 400.0
    height: float = 260.0


def line_chart(series: Sequence[Series], frame: Frame) -> str:
    """Lines with intervals: bands where values are many, bars where they are few."""
    told = [one for one in series if one.points]
    if not told:
        return ""
    xs = [p.x for one in told for p in one.points]
    ys = [v for one in told for p in one.points for v in (p.y, p.low, p.high) if v is not None]
    x, y = _Axis.over(xs, frame.x_range), _Axis.over(ys, frame.y_range, frame.y_bounds)
    place = _Place(frame, x, y)
    marks = [place.grid()]
    if frame.diagonal:
        ends = (max(x.low, y.low), min(x.high, y.high))
        path = " ".join(f"{place.x(v):.1f},{place.y(v):.1f}" for v in ends)
        marks.append(f'<polyline points="{path}" class="even"/>')
    marks += [_drawn(one, place, f"var(--name-{one.color})", frame.steps) for one in told]
    label = escape(f"{frame.title}: {frame.y} over {frame.x}")
    svg = (
        f'<svg viewBox="0 0 {frame.width:g} {frame.height:g}" role="img" aria-label="{label}">'
        f"{''.join(marks)}</svg>"
    )
    key = "".join(
        f'<li><span class="swatch" style="background: var(--name-{one.color})"></span>{escape(one.name)}</li>'
        for one in told
        if one.name
    )
    legend = f'<ul class="legend">{key}</ul>' if key else ""
    return f'<figure class="chart"><figcaption>{escape(frame.title)}</figcaption>{svg}{legend}</figure>'


def dot_chart(
    rows: Sequence[Series],
    title: str,
    x: str,
    zero: bool = False,
    bounds: tuple[float, float] = (-math.inf, math.inf),
) -> str:
    """A row for each series, its points along x, whose own x is not used; `zero` draws where nothing differs."""
    if not rows:
        return ""
    values = [v for row in rows for p in row.points for v in (p.y, p.low, p.high) if v is not None]
    axis = _Axis.over([*values, 0.0] if zero else values, None, bounds)
    left = min(170.0, 14.0 + 6.2 * max(len(row.name) for row in rows))
    width, step, top = 400.0, 22.0, 10.0
    height = top + step * len(rows) + 36.0

    def at(value: float) -> float:
        inside = min(max(value, axis.low), axis.high)
        return left + (inside - axis.low) / (axis.high - axis.low) * (width - left - 16.0)

    base = top + step * len(rows)
    marks = [
        f'<line x1="{at(t):.1f}" y1="{top}" x2="{at(t):.1f}" y2="{base}" class="grid"/>'
        f'<text x="{at(t):.1f}" y="{base + 15}" text-anchor="middle">{_number(t)}</text>'
        for t in axis.ticks
    ]
    if zero:
        marks.append(f'<line x1="{at(0):.1f}" y1="{top}" x2="{at(0):.1f}" y2="{base}" class="even"/>')
    for k, row in enumerate(rows):
        y, color = top + step * (k + 0.5), f"var(--name-{row.color})"
        for p in row.points:
            if p.low is not None and p.high is not None:
                marks.append(
                    f'<line x1="{at(p.low):.1f}" y1="{y}" x2="{at(p.high):.1f}" y2="{y}" class="interval" '
                    f'style="stroke: {color}"/>'
                )
            marks.append(f'<circle cx="{at(p.y):.1f}" cy="{y}" r="3.6" style="fill: {color}"/>')
        marks.append(f'<text x="{left - 8}" y="{y + 4}" text-anchor="end">{escape(_short(row.name))}</text>')
    marks.append(
        f'<text x="{(left + width) / 2:.1f}" y="{height - 3}" text-anchor="middle">{escape(x)}</text>'
    )
    return (
        f'<figure class="chart"><figcaption>{escape(title)}</figcaption><svg viewBox="0 0 {width:g} {height:g}" '
        f'role="img" aria-label="{escape(f"{title}: {x}")}">{"".join(marks)}</svg></figure>'
    )


@dataclass(frozen=True)
class _Axis:
    low: float
    high: float
    ticks: tuple[float, ...]

    @staticmethod
    def over(
        values: Sequence[float],
        fixed: tuple[float, float] | None,
        bounds: tuple[float, float] = (-math.inf, math.inf),
    ) -> _Axis:
        """Round ends about the values, or fixed ones; never past what the values may be."""
        low, high = fixed or (min(values), max(values))
        if high - low < 1e-12:
            pad = abs(low) * 0.1 or 0.5
            low, high = low - pad, high + pad
        step = _nice((high - low) / 4.0)
        if fixed is None:
            low, high = step * math.floor(low / step + 1e-9), step * math.ceil(high / step - 1e-9)
            low, high = max(low, bounds[0]), min(high, bounds[1])
        first = math.ceil(low / step - 1e-9)
        count = math.floor((high - first * step) / step + 1e-9) + 1
        return _Axis(low, high, tuple((first + k) * step for k in range(count)))


@dataclass(frozen=True)
class _Place:
    frame: Frame
    across: _Axis
    up: _Axis

    def x(self, value: float) -> float:
        share = (value - self.across.low) / (self.across.high - self.across.low)
        return _LEFT + share * (self.frame.width - _LEFT - _RIGHT)

    def y(self, value: float) -> float:
        inside = min(max(value, self.up.low), self.up.high)
        share = (inside - self.up.low) / (self.up.high - self.up.low)
        return self.frame.height - _BOTTOM - share * (self.frame.height - _TOP - _BOTTOM)

    def grid(self) -> str:
        right, base = self.frame.width - _RIGHT, self.frame.height - _BOTTOM
        rows = "".join(
            f'<line x1="{_LEFT}" y1="{self.y(t):.1f}" x2="{right}" y2="{self.y(t):.1f}" class="grid"/>'
            f'<text x="{_LEFT - 6}" y="{self.y(t) + 4:.1f}" text-anchor="end">{_number(t)}</text>'
            for t in self.up.ticks
        )
        columns = "".join(
            f'<text x="{self.x(t):.1f}" y="{base + 16}" text-anchor="middle">{_number(t)}</text>'
            for t in self.across.ticks
        )
        middle = (_LEFT + right) / 2.0
        return (
            f'{rows}{columns}<text x="{middle:.1f}" y="{self.frame.height - 6}" text-anchor="middle">'
            f"{escape(self.frame.x)}</text>"
        )


def _drawn(one: Series, place: _Place, color: str, steps: bool) -> str:
    points = sorted(one.points, key=lambda p: p.x)
    spread = [p for p in points if p.low is not None and p.high is not None]
    marks = []
    if steps:
        above = [f"{place.x(p.x):.1f},{place.y(p.high or 0.0):.1f}" for p in spread]
        below = [f"{place.x(p.x):.1f},{place.y(p.low or 0.0):.1f}" for p in reversed(spread)]
        marks.append(f'<polygon points="{" ".join([*above, *below])}" class="band" style="fill: {color}"/>')
    else:
        marks += [
            f'<line x1="{place.x(p.x):.1f}" y1="{place.y(p.low or 0.0):.1f}" x2="{place.x(p.x):.1f}" '
            f'y2="{place.y(p.high or 0.0):.1f}" class="interval" style="stroke: {color}"/>'
            for p in spread
        ]
    path = " ".join(f"{place.x(p.x):.1f},{place.y(p.y):.1f}" for p in points)
    marks.append(f'<polyline points="{path}" class="line" style="stroke: {color}"/>')
    if not steps or len(points) == 1:
        marks += [
            f'<circle cx="{place.x(p.x):.1f}" cy="{place.y(p.y):.1f}" r="3.4" style="fill: {color}"/>'
            for p in points
        ]
    return "".join(marks)


def _nice(value: float) -> float:
    power = 10.0 ** math.floor(math.log10(value))
    return float(next(m * power for m in (1.0, 2.0, 2.5, 5.0, 10.0) if m * power >= value * 0.999))


def _number(value: float) -> str:
    return f"{value + 0.0:.4g}"


def _short(name: str) -> str:
    return name if len(name) <= 26 else name[:25] + "…"
