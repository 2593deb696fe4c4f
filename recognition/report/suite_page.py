"""The page of a suite: one HTML file of charts and tables with intervals, without a script."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from recognition.report import tables
from recognition.report.shell import shell
from recognition.report.suite_charts import charts, named, word
from recognition.report.tables import worded

Json = Mapping[str, Any]
_NOTE = (
    "Intervals are 95 %: Wilson's for shares, bootstrap for medians, Student's for differences. Where a group has "
    "several parts, parts are the units: trials of one part count together. Trials that were not done are counted "
    "under done, and in no other number."
)
_MANY = 200  # rows of a table


def suite_html(summary: Json) -> str:
    """The page as text."""
    body = "".join(_group(group) for group in summary["groups"])
    reasons = "".join(f"<li>{n} × {escape(why)}</li>" for why, n in summary["reasons"].items())
    told = tables.section("Not done", f'<ul class="warnings">{reasons}</ul>' if reasons else "")
    state = "" if summary["complete"] else " The other shards are still to come."
    done = sum(n for name, n in summary["outcomes"].items() if name == "done")
    figures = tables.figure_cells(
        [
            ("Trials", summary["trials"], ""),
            ("Done", done, ""),
            ("Not done", summary["rows"] - done, ""),
            ("Work", f"{summary['work_seconds']:.0f}", "s"),
        ]
    )
    return shell(
        title=escape(str(summary["suite"])),
        lede=f"{escape(summary['about'])}{state}",
        figures=figures,
        main=told + body,
        footer=f"palpate {escape(summary['version'])}. {_NOTE}",
        styles=("suite.css",),
    )


def _group(group: Json) -> str:
    name = str(group["name"])
    every = list(dict.fromkeys(m for cell in group["cells"] for m in cell["metrics"]))
    main = [metric for metric in group["shown"] if metric in every]
    details = [
        _folded("All metrics", _cells(f"{name}, all metrics", group["cells"], every)),
        _folded("By part", _cells(f"{name}, by part", group["parts"], main)) if group["parts"] else "",
        _folded("Compared, trial by trial", _compared(name, group["compared"])),
        *(_confusion(name, cell) for cell in group["cells"]),
    ]
    return (
        f'<section class="group"><h2 class="title">{escape(name)}</h2><p class="lede">{escape(group["about"])}</p>'
        f"{charts(group)}{_cells(name, group['cells'], main)}{''.join(details)}</section>"
    )


def _cells(label: str, cells: Sequence[Json], metrics: Sequence[str]) -> str:
    """One row a condition, one column a metric."""
    axes = list(dict.fromkeys(axis for cell in cells for axis in cell["settings"]))
    head = [*(worded(axis) for axis in axes), "Trials", "Done", *(worded(name) for name in metrics)]
    rows = [
        [
            *(escape(word(cell["settings"].get(axis))) for axis in axes),
            str(cell["trials"]),
            _told(cell["done"]),
            *(_told(cell["metrics"].get(name)) for name in metrics),
        ]
        for cell in cells[:_MANY]
    ]
    return _table(label, head, rows, len(axes))


def _compared(label: str, compared: Sequence[Json]) -> str:
    head = ["Metric", "Better", "Second", "First", "Within", "Mean difference", "Second better", "Alike"]
    rows = [
        [
            escape(worded(one["metric"])),
            escape(one["better"]),
            escape(word(one["second"])),
            escape(word(one["first"])),
            escape(named(one["within"])) or "all",
            _told(one["difference"]),
            _told(one["second_better"]),
            str(one["same"]),
        ]
        for one in compared[:_MANY]
    ]
    return _table(f"{label}, compared", head, rows, 5) if rows else ""


def _confusion(label: str, cell: Json) -> str:
    """Objects down, decisions across; nothing where there is too much for a table."""
    told = cell.get("confusion") or []
    answers = sorted({one["answer"] for one in told})
    decisions = sorted({one["decision"] for one in told}, key=lambda name: (name not in answers, name))
    if not told or len(decisions) > 40:
        return ""
    counts = {(one["answer"], one["decision"]): one["trials"] for one in told}
    total = {answer: sum(n for (a, _), n in counts.items() if a == answer) for answer in answers}
    rows = [
        [escape(answer), *(_count(counts.get((answer, d), 0), total[answer], answer == d) for d in decisions)]
        for answer in answers
    ]
    where = named(cell["settings"])
    title = f"Confusion{f' ({where})' if where else ''}"
    return _folded(title, _table(f"{label}, {title}", ["Object", *decisions], rows, 1))


def _count(count: int, total: int, right: bool) -> str:
    if not count:
        return ""
    color = "good" if right else "warn"
    mix = f"color-mix(in srgb, var(--{color}) {round(45 * count / total)}%, transparent)"
    return f'<span class="count" style="background: {mix}">{count}</span>'


def _table(label: str, head: Sequence[str], rows: Sequence[Sequence[str]], words: int) -> str:
    """A table whose first `words` columns are words and the others numbers."""

    def align(column: int) -> str:
        return "" if column < words else ' class="number"'

    titles = "".join(f'<th scope="col"{align(k)}>{escape(title)}</th>' for k, title in enumerate(head))
    body = "".join(
        "<tr>" + "".join(f"<td{align(k)}>{cell}</td>" for k, cell in enumerate(row)) + "</tr>" for row in rows
    )
    region = f'<div class="scroll" tabindex="0" role="region" aria-label="{escape(label)}">'
    return f"{region}<table><thead><tr>{titles}</tr></thead><tbody>{body}</tbody></table></div>"


def _folded(title: str, body: str) -> str:
    return f"<details><summary>{escape(title)}</summary>{body}</details>" if body else ""


def _told(estimate: Json | None) -> str:
    if estimate is None:
        return ""
    if estimate["low"] is None:
        return f"{estimate['value']:.4g}"
    return f"{estimate['value']:.4g} <small>{estimate['low']:.3g} to {estimate['high']:.3g}</small>"
