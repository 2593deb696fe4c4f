"""What is drawn of a group of trials: metrics over conditions, names against touches, calibration, differences."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from recognition.experiments.kinds import KINDS
from recognition.report.chart import COLORS, Frame, Point, Series, dot_chart, line_chart
from recognition.report.tables import worded

Json = Mapping[str, Any]
_MANY = 30  # rows of a chart of dots


def charts(group: Json) -> str:
    """All of a group's charts."""
    cells = [cell for cell in group["cells"] if cell["trials"]]
    drawn = [
        _touches(group, cells),
        *(_metric(group, cells, name) for name in group["shown"] if len(cells) > 1),
        _calibration(group, cells),
        *(_differences(group) if group["parts"] else ()),
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


def _colored(group: Json, points: Mapping[str, Sequence[Point]], without: str = "") -> list[Series]:
    """Series in the color that their condition has in every chart of the group, as far as there are colors."""
    order = dict.fromkeys(named(_less(cell["settings"], without)) for cell in group["cells"])
    color = {name: k for k, name in enumerate(order)}
    return [Series(name, told, color[name]) for name, told in points.items() if color[name] < COLORS]


def _less(settings: Json, axis: str) -> dict[str, Any]:
    return {key: value for key, value in settings.items() if key != axis}


def _touches(group: Json, cells: Sequence[Json]) -> str:
    points = {
        named(cell["settings"]): [_point(step["touch"], step) for step in cell["touch_curve"]]
        for cell in cells
        if cell.get("touch_curve")
    }
    frame = Frame("Right names against touches", "touches", "share right", y_range=(0.0, 1.0), steps=True)
    return line_chart(_colored(group, points), frame)


def _metric(group: Json, cells: Sequence[Json], name: str) -> str:
    told = [(cell["settings"], cell["metrics"][name]) for cell in cells if cell["metrics"].get(name)]
    title, bounds = worded(name), _bounds(group, name)
    if len(told) < 2:
        return ""
    axis = next((a for a, values in group["conditions"].items() if _numeric(values)), None)
    if axis is None:
        dots = {named(settings): [_point(0.0, found)] for settings, found in told}
        few = len(group["cells"]) <= COLORS
        rows = _colored(group, dots) if few else [Series(key, points) for key, points in dots.items()]
        return dot_chart(rows[:_MANY], title, title, bounds=bounds)
    lines: dict[str, list[Point]] = {}
    for settings, found in told:
        lines.setdefault(named(_less(settings, axis)), []).append(_point(float(settings[axis]), found))
    whole = bounds if told[0][1]["of"] == "share" else None
    frame = Frame(title, worded(axis), title, y_range=whole, y_bounds=bounds)
    return line_chart(_colored(group, lines, axis), frame)


def _bounds(group: Json, name: str) -> tuple[float, float]:
    """What a metric may be: nothing that trials tell is below 0, and no share is above 1."""
    metric = KINDS[group["kind"]].metrics.get(name)
    return 0.0, 1.0 if metric is None or metric.type is bool else metric.most


def _calibration(group: Json, cells: Sequence[Json]) -> str:
    points = {
        named(cell["settings"]): [_point(b["confidence"], b) for b in cell["calibration"]["bins"]]
        for cell in cells
        if cell.get("calibration")
    }
    frame = Frame("Calibration", "stated confidence", "share right", (0.0, 1.0), (0.0, 1.0), diagonal=True)
    return line_chart(_colored(group, points), frame)


def _differences(group: Json) -> list[str]:
    """By part, for each two ways and metric, the first few of them."""
    out = []
    for one in group["compared"]:
        if len(one["by_part"]) < 2:
            continue
        rows = [Series(name, [Point(0.0, gain)]) for name, gain in one["by_part"].items()]
        rows = [Series("all", [_point(0.0, one["difference"])]), *rows]
        most = _bounds(group, one["metric"])[1]
        within = f" ({named(one['within'])})" if one["within"] else ""
        title = f"{worded(one['metric'])}: {one['second']} less {one['first']}{within}"
        out.append(
            dot_chart(rows[:_MANY], title, f"difference; {one['better']} is better", True, (-most, most))
        )
    return out[:6]


def _point(x: float, found: Json) -> Point:
    return Point(x, found["value"], found["low"], found["high"])


def _numeric(values: Sequence[Any]) -> bool:
    return all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)
