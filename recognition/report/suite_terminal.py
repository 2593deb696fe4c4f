"""A suite as a terminal shows it: how trials ended, and each group's main metrics under each condition."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from recognition.report.suite_charts import word
from recognition.report.tables import worded
from recognition.report.terminal import table_text

_FEW = 5  # metrics of a table, so that it fits a terminal; the page has them all


def suite_text(summary: Mapping[str, Any], folder: Path) -> str:
    """What `experiment` prints."""
    outcomes = ", ".join(f"{count} {name}" for name, count in summary["outcomes"].items())
    lines = [f"{summary['suite']}: {summary['rows']} of {summary['trials']} trials ({outcomes})"]
    lines += [f"  {count} x {why}" for why, count in summary["reasons"].items()]
    for group in summary["groups"]:
        lines += ["", group["name"], table_text(_rows(group["cells"], group["shown"]))]
        for cell in group["cells"]:
            if found := cell.get("calibration"):
                where = ", ".join(word(value) for value in cell["settings"].values())
                error = found["expected_calibration_error"]
                lines.append(f"calibration{f', {where}' if where else ''}: off by {error:.3f} on average")
    lines += ["", "95 % intervals in parentheses"]
    return "\n".join(
        [*lines, "", f"report: {folder / 'report.html'}", f"table: {folder / 'results.parquet'}"]
    )


def _rows(cells: Sequence[Mapping[str, Any]], shown: Sequence[str]) -> list[dict[str, object]]:
    names = [name for name in shown if any(name in cell["metrics"] for cell in cells)][:_FEW]
    out = list[dict[str, object]]()
    for cell in cells:
        row: dict[str, object] = {worded(a).lower(): word(value) for a, value in cell["settings"].items()}
        row["trials"] = str(cell["trials"])
        row["done"] = str(_done(cell["done"]))
        out.append(row | {worded(name).lower(): _told(cell["metrics"].get(name)) for name in names})
    return out


def _done(finished: Mapping[str, Any] | None) -> int:
    """How many trials ended well."""
    return 0 if finished is None else round(finished["value"] * finished["count"])


def _told(estimate: Mapping[str, Any] | None) -> str:
    if estimate is None:
        return ""
    if estimate["low"] is None:
        return f"{estimate['value']:.3g}"
    return f"{estimate['value']:.3g} ({estimate['low']:.3g} to {estimate['high']:.3g})"
