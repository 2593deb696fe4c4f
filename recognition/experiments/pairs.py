"""Two ways of doing the same thing compared on the same trials: the differences, by part.

Trials are paired that share every setting but the one that tells the ways apart.  Differences are meant over the
trials of a part, and the interval is over parts; it is told apart for every value of the other settings.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from recognition.experiments.settings import Value
from recognition.experiments.statistics import mean_of_units, share
from recognition.experiments.suite import Group
from recognition.experiments.trial import Row

METHODS = ("policy", "detector")  # settings whose values compete
_SAME = 1e-12


def compared(group: Group, rows: Sequence[Row], metrics: Sequence[str]) -> list[dict[str, Any]]:
    """Every way against the first, for each metric that is better high or low."""
    out = []
    for axis in METHODS:
        values = group.axes.get(axis, ())
        others = [name for name in group.conditions if name != axis]
        for point in sorted({tuple(row[name] for name in others) for row in rows}, key=str):
            within = dict(zip(others, point, strict=True))
            mine = [row for row in rows if all(row[name] == value for name, value in within.items())]
            for second in values[1:]:
                for metric in metrics:
                    told = _difference(group, mine, axis, (values[0], second), metric)
                    if told is not None:
                        out.append({"axis": axis, "within": within, **told})
    return out


def _difference(
    group: Group, rows: Sequence[Row], axis: str, ways: tuple[Value, Value], metric: str
) -> dict[str, Any] | None:
    better = group.kind.metrics[metric].better if metric in group.kind.metrics else "high"
    if not better:
        return None
    keys = [name for name in group.kind.settings if name != axis]
    first, second = (
        {tuple(row[k] for k in keys): row for row in rows if row[axis] == way and row.get(metric) is not None}
        for way in ways
    )
    both = [key for key in first if key in second]
    gains = [_number(second[key][metric]) - _number(first[key][metric]) for key in both]
    units = [group.unit(first[key]) for key in both]
    found = mean_of_units(gains, units)
    if found is None:
        return None
    sign = 1.0 if better == "high" else -1.0
    decided = [(sign * gain > 0, unit) for gain, unit in zip(gains, units, strict=True) if abs(gain) > _SAME]
    wins = share([won for won, _ in decided], [unit for _, unit in decided])
    return {
        "metric": metric,
        "better": better,
        "first": ways[0],
        "second": ways[1],
        "difference": {"of": "mean difference", **asdict(found)},
        "second_better": None if wins is None else {"of": "share", **asdict(wins)},
        "same": len(gains) - len(decided),
        "by_part": _by_part(gains, units),
    }


def _by_part(gains: Sequence[float], units: Sequence[Any]) -> Mapping[str, float]:
    names = dict.fromkeys(str(unit) for unit in units)
    told = list(zip(gains, units, strict=True))
    return {
        name: sum(g for g, unit in told if str(unit) == name) / sum(str(unit) == name for _, unit in told)
        for name in names
    }


def _number(value: Value) -> float:
    return float(value) if isinstance(value, int | float) else float("nan")
