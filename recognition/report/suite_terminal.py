"""A suite as a terminal shows it: how trials ended, and each group along its axes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from recognition.report.terminal import table_text

_FEW = 6  # metrics of a table, so that it fits a terminal; the page has them all


def suite_text(summary: Mapping[str, Any], folder: Path) -> str:
    """What `experiment` prints."""
    outcomes = ", ".join(f"{count} {name}" for name, count in summary["outcomes"].items())
    lines = [f"{summary['suite']}: {summary['rows']} of {summary['trials']} trials ({outcomes})"]
    lines += [f"  {count} x {why}" for why, count in summary["reasons"].items()]
    for group in summary["groups"]:
        axes = group["axes"] or {"": [{"value": "all", **group}]}
        for axis, cells in axes.items():
            lines += [
                "",
                f"{group['name']}{f' by {axis}' if axis else ''}",
                table_text(_rows(cells)),
            ]
    return "\n".join(
        [*lines, "", f"report: {folder / 'report.html'}", f"table: {folder / 'results.parquet'}"]
    )


def _rows(cells: Sequence[Mapping[str, Any]]) -> list[dict[str, object]]:
    names = list(dict.fromkeys(name for cell in cells for name in cell["metrics"]))[:_FEW]
    return [
        {"": str(cell["value"]), "trials": str(cell["trials"])}
        | {name: _told(cell["metrics"].get(name)) for name in names}
        for cell in cells
    ]


def _told(estimate: Mapping[str, Any] | None) -> str:
    if estimate is None:
        return ""
    return f"{estimate['value']:.3g} ({estimate['low']:.3g} to {estimate['high']:.3g})"
