"""What a suite came to: every metric of every group, over each value of each axis, with its interval."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import version
from typing import Any

from recognition.experiments.statistics import Estimate, median, wilson
from recognition.experiments.suite import Group, Suite
from recognition.experiments.trial import DONE, OUTCOMES, Row

_NUMBERS = (int, float)


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
    """All of it, and along each axis but the seed; the trials that did not end well are counted, not averaged."""
    axes = {
        axis: [{"value": value, **_cell(group, [r for r in rows if r[axis] == value])} for value in values]
        for axis, values in group.axes.items()
        if axis != "seed"
    }
    return {"name": group.name, "kind": group.kind.name, **_cell(group, rows), "axes": axes}


def _cell(group: Group, rows: Sequence[Row]) -> dict[str, Any]:
    done = [row for row in rows if row["outcome"] == DONE]
    metrics: dict[str, Any] = {}
    for name, metric in group.kind.metrics.items():
        told = [row[name] for row in done if row.get(name) is not None]
        found: Estimate | None = None
        if metric.type is bool:
            found = wilson(sum(map(bool, told)), len(told))
        elif metric.type in _NUMBERS:
            found = median([float(value) for value in told if isinstance(value, int | float)])
        if found is not None:
            metrics[name] = {"of": "share" if metric.type is bool else "median", **asdict(found)}
    finished: Mapping[str, Any] | None = None
    if share := wilson(len(done), len(rows)):
        finished = {"of": "share", **asdict(share)}
    return {"trials": len(rows), "done": finished, "metrics": metrics}
