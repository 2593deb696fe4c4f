"""What is drawn of a group of trials: metrics over conditions, names against touches, calibration, differences."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from recognition.report.chart import COLORS, Frame, Point, Series, dot_chart, line_chart
from recognition.report.tables import worded

Json = Mapping[str, Any]
_MANY = 30  # rows of a chart of dots


def charts(group: Json) -> str:
    """All of a group's charts."""
    cells = [cell for cell in group["cells"] if cell["trials"]]
    drawn = [
        _touches(cells),
        *(_metric(group, cells, name) for name in group["shown"] if len(cells) > 1),
        _calibration(cells),
        *(_differences(group["compared"]) if group["parts"] else ()),
    ]
    return f'<div class="charts">{"".join(drawn)}</div>' if any(drawn) else ""


def named(settings: Json) -> str:
    """A condition in a few words: its values alone where they are texts, else with the setting's name."""
    return ", ".join(
        str(value) if isinstance(value, str) and value else f"{worded(axis).lower()} {word(value)}"
        for axis, value in settings.items()
    )


def word(value: object) -> str:
    """A setting's value."""
    if value is None or value == "":
        return "as built"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g}" if isinstance(value, float) else str(value)


def _touches(cells: Sequence[Json]) -> str:
    series = [
        Series(named(cell["settings"]), [_point(step["touch"], step) for step in cell["touch_curve"]])
        for cell in cells
        if cell.get("touch_curve")
    ]
    frame = Frame("Right names against touches", "touches", "share right", y_range=(0.0, 1.0), steps=True)
    return line_chart(series[:COLORS], frame)


def _metric(group: Json, cells: Sequence[Json], name: str) -> str:
    told = [(cell["settings"], cell["metrics"][name]) for cell in cells if cell["metrics"].get(name)]
    title = worded(name)
    if len(told) < 2:
        return ""
    axis = next((a for a, values in group["conditions"].items() if _numeric(values)), None)
    if axis is None:
        rows = [(named(settings), _point(0.0, found)) for settings, found in told]
        return dot_chart(rows[:_MANY], title, title)
    lines: dict[str, list[Point]] = {}
    for settings, found in told:
        others = {key: value for key, value in settings.items() if key != axis}
        lines.setdefault(named(others), []).append(_point(float(settings[axis]), found))
    frame = Frame(title, worded(axis), title, y_range=(0.0, 1.0) if told[0][1]["of"] == "share" else None)
    return line_chart([Series(key, points) for key, points in lines.items()][:COLORS], frame)


def _calibration(cells: Sequence[Json]) -> str:
    series = [
        Series(named(cell["settings"]), [_point(b["confidence"], b) for b in cell["calibration"]["bins"]])
        for cell in cells
        if cell.get("calibration")
    ]
    frame = Frame("Calibration", "stated confidence", "share right", (0.0, 1.0), (0.0, 1.0), diagonal=True)
    return line_chart(series[:COLORS], frame)


def _differences(compared: Sequence[Json]) -> list[str]:
    """By part, for each two ways and metric, the first few of them."""
    out = []
    for one in compared:
        if len(one["by_part"]) < 2:
            continue
        rows = [(name, Point(0.0, gain)) for name, gain in one["by_part"].items()]
        rows = [("all", _point(0.0, one["difference"])), *rows]
        within = f" ({named(one['within'])})" if one["within"] else ""
        title = f"{worded(one['metric'])}: {one['second']} less {one['first']}{within}"
        out.append(dot_chart(rows[:_MANY], title, f"difference; {one['better']} is better", zero=True))
    return out[:6]


def _point(x: float, found: Json) -> Point:
    return Point(x, found["value"], found["low"], found["high"])


def _numeric(values: Sequence[Any]) -> bool:
    return all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)
