"""The run page: one HTML file that needs nothing else, neither network nor server.

The template's `{{name}}` places are filled once, from left to right; what fills them is never searched again.
"""

from __future__ import annotations

import re
from html import escape
from importlib.resources import files
from pathlib import Path

from recognition.report import tables
from recognition.report.payload import left_out, payload
from recognition.report.run_report import RunReport
from recognition.run_folder import json_text

_SCRIPTS = ("gl.js", "scene.js", "panels.js", "theme.js", "main.js")
_LAYERS = (
    ("model", "Model"),
    ("truth", "Truth"),
    ("contacts", "Contacts"),
    ("traces", "Traces"),
    ("pad", "Pad"),
)
_FELT = "Felt faces"  # in the model's place where there is none


def write_report(path: Path, report: RunReport) -> None:
    """Write the page of one run."""
    path.write_text(report_html(report), encoding="utf-8")


def report_html(report: RunReport) -> str:
    """The page as text."""
    summary = report.summary
    opened = tables.without_body(summary)
    present = {
        "model": report.model is not None,
        "truth": report.truth is not None,
        "contacts": len(report.contacts) > 0,
        "traces": len(report.traces) > 0,
        "pad": len(report.frames.times) > 0,
    }
    places = {
        "title": escape(str(summary.get("part") or "a touched object")),
        "style": resource("style.css"),
        "lede": tables.lede(summary),
        "figures": tables.figures(summary),
        "layers": "".join(
            _layer(name, _FELT if name == "model" and opened else label, name != "truth" or opened)
            for name, label in _LAYERS
            if present[name]
        ),
        "legend": tables.legend(summary, present["traces"]),
        "sections": tables.sections(summary, report.settings, left_out(report)),
        "footer": escape(
            f"palpate {summary.get('version', '')}, seed {summary.get('seed', '')}. Lengths in mm, world frame."
        ),
        "data": json_text(payload(report)).replace("<", "\\u003c"),
        "script": "\n".join(resource(name) for name in _SCRIPTS).replace('"use strict";\n', ""),
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda place: places[place[1]], resource("page.html"))


def _layer(name: str, label: str, shown: bool) -> str:
    checked = " checked" if shown else ""
    return f'<label><input type="checkbox" data-layer="{name}"{checked}>{label}</label>'


def resource(name: str) -> str:
    """A file beside this one, as text."""
    return (files(__package__) / name).read_text(encoding="utf-8")
