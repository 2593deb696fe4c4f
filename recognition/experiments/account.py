"""What a suite came to: for each group its metrics under each condition, compared, and what recognition adds.

A group's axes are conditions, which are never averaged over, but for the part and the seed, which repeat a trial.
Where there are several parts they are the units of the intervals: what holds for these parts, for parts like them.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import version
from typing import Any

from recognition.experiments.pairs import compared
from recognition.experiments.rates import AREA, against_touches, calibration, confusion, held
from recognition.experiments.statistics import Estimate, Unit, median, share
from recognition.experiments.suite import Group, Suite
from recognition.experiments.trial import DONE, OUTCOMES, Row


def account(suite: Suite, rows: Sequence[Row], wall_seconds: float) -> dict[str, Any]:
    """The summary of a suite."""
    outcomes = Counter(str(row["outcome"]) for row in rows)
    reasons = Counter(str(row["reason"]) for row in rows if row["outcome"] != DONE)
    return {
        "command": "experiment",
        "version": version("palpate"),
        "suite": suite.name,
        "about": suite.about,
        "trials": len(suite.trials),
        "rows": len(rows),
        "complete": len(rows) == len(suite.trials),
        "outcomes": {name: outcomes[name] for name in OUTCOMES if outcomes[name]},
        "reasons": dict(reasons.most_common()),
        "groups": [
            _group(group, [row for row in rows if row["group"] == group.name]) for group in suite.groups
        ],
        "work_seconds": sum(float(row["trial_seconds"] or 0.0) for row in rows),
        "wall_seconds": wall_seconds,
        "warnings": [],
        "files": {"table": "results.parquet", "report": "report.html"},
    }


def _group(group: Group, rows: Sequence[Row]) -> dict[str, Any]:
    parts = group.axes.get("part", ())
    done = [row for row in rows if row["outcome"] == DONE]
    shown = [*group.kind.shown, *([AREA] if "first_touches_right" in group.kind.metrics else [])]
    return {
        "name": group.name,
        "kind": group.kind.name,
        "about": group.kind.about,
        "shown": list(shown),
        "conditions": {axis: list(group.axes[axis]) for axis in group.conditions},
        "cells": [_cell(group, condition, mine) for condition, mine in _conditions(group, rows)],
        "parts": [
            _cell(group, {"part": part, **condition}, [row for row in mine if row["part"] == part])
            for condition, mine in _conditions(group, rows)
            for part in parts
        ],
        "compared": compared(group, [_with_area(row) for row in done], shown),
    }


def _conditions(group: Group, rows: Sequence[Row]) -> list[tuple[dict[str, Any], list[Row]]]:
    """Every point of the axes that are conditions, and its rows."""
    points = itertools.product(*(group.axes[axis] for axis in group.conditions))
    named = [dict(zip(group.conditions, point, strict=True)) for point in points]
    return [
        (point, [row for row in rows if all(row[axis] == value for axis, value in point.items())])
        for point in named
    ]


def _cell(group: Group, settings: Mapping[str, Any], rows: Sequence[Row]) -> dict[str, Any]:
    """Metrics over the trials that ended well; the others are counted, not averaged."""
    done = [_with_area(row) for row in rows if row["outcome"] == DONE]
    units = [group.unit(row) for row in done]
    metrics = {}
    for name, metric in group.kind.metrics.items():
        found = _estimate(metric.type, done, units, name)
        if found is not None:
            metrics[name] = {"of": "share" if metric.type is bool else "median", **asdict(found)}
    finished = share([row["outcome"] == DONE for row in rows], [group.unit(row) for row in rows])
    cell: dict[str, Any] = {
        "settings": dict(settings),
        "trials": len(rows),
        "done": None if finished is None else {"of": "share", **asdict(finished)},
        "metrics": metrics,
    }
    if "correct" in group.kind.metrics and "part" not in settings:
        touches = against_touches(done, units)
        if touches is not None:
            metrics[AREA] = touches["area"]
            cell["touch_curve"] = touches["curve"]
        cell |= {"calibration": calibration(done, units), "confusion": confusion(done)}
    return cell


def _estimate(kind: type, rows: Sequence[Row], units: Sequence[Unit], name: str) -> Estimate | None:
    told = [(row[name], unit) for row, unit in zip(rows, units, strict=True) if row.get(name) is not None]
    mine = [unit for _, unit in told]
    if kind is bool:
        return share([bool(value) for value, _ in told], mine)
    if kind in (int, float):
        return median([float(value) for value, _ in told if isinstance(value, int | float)], mine)
    return None


def _with_area(row: Row) -> Row:
    """A row with its own area under the curve of touches, where it has touches."""
    told, most = row.get("first_touches_right"), row.get("max_touches")
    if told is None or not isinstance(most, int) or most < 1:
        return row
    return {**row, AREA: sum(held(str(told), most)) / most}
