"""The page of a suite: one HTML file of tables with intervals, without a script."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any

from recognition.report.page import resource

_HEAD = (
    '<!doctype html><html lang="en"><head><meta charset="utf-8">'
    '<meta name="viewport" content="width=device-width, initial-scale=1">'
    "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'\">"
    '<meta name="color-scheme" content="light dark">'
)


def suite_html(summary: Mapping[str, Any]) -> str:
    """The page as text."""
    title = escape(str(summary["suite"]))
    body = "".join(_group(group) for group in summary["groups"])
    reasons = "".join(f"<li>{n} × {escape(why)}</li>" for why, n in summary["reasons"].items())
    told = f'<section class="table"><h2>Not done</h2><ul class="warnings">{reasons}</ul></section>'
    state = "" if summary["complete"] else " The other shards are still to come."
    return (
        f"{_HEAD}<title>{title} · palpate</title><style>{resource('style.css')}</style></head><body>"
        f'<header><p class="mark">palpate</p><h1>{title}</h1><p class="lede">{escape(summary["about"])} '
        f"{summary['rows']} of {summary['trials']} trials.{state}</p></header>"
        f"<main>{told if reasons else ''}{body}</main>"
        f"<footer><p>palpate {escape(summary['version'])}. Shares with 95 % Wilson intervals, medians with 95 % "
        "bootstrap intervals over the trials that were done.</p></footer></body></html>"
    )


def _group(group: Mapping[str, Any]) -> str:
    name = escape(str(group["name"]))
    tables = [_table(name, {"all": [{"value": "all", **group}]})]
    tables += [_table(f"{name} by {axis}", {axis: cells}) for axis, cells in group["axes"].items()]
    return "".join(tables)


def _table(title: str, axes: Mapping[str, Any]) -> str:
    ((axis, cells),) = axes.items()
    names = list(dict.fromkeys(name for cell in cells for name in cell["metrics"]))
    head = "".join(f'<th scope="col" class="number">{escape(name)}</th>' for name in ("done", *names))
    rows = "".join(
        f'<tr><th scope="row">{escape(_word(cell["value"]))}</th><td class="number">{_told(cell["done"])}</td>'
        + "".join(f'<td class="number">{_told(cell["metrics"].get(name))}</td>' for name in names)
        + "</tr>"
        for cell in cells
    )
    return (
        f'<section class="table"><h2>{escape(title)}</h2><div class="scroll" tabindex="0" role="region" '
        f'aria-label="{escape(title)}"><table><thead><tr><th scope="col">{escape(axis)}</th>{head}</tr></thead>'
        f"<tbody>{rows}</tbody></table></div></section>"
    )


def _told(estimate: Mapping[str, Any] | None) -> str:
    if estimate is None:
        return ""
    return f"{estimate['value']:.4g} <small>{estimate['low']:.3g} to {estimate['high']:.3g}</small>"


def _word(value: object) -> str:
    return "as built" if value is None else str(value)
