"""The run page: the object, the pad moving, what it felt and what was believed at each moment, and tables."""

from __future__ import annotations

from html import escape
from pathlib import Path

import numpy as np

from recognition.report import tables
from recognition.report.payload import left_out, payload
from recognition.report.run_report import EMPTY_FRAMES, RunReport
from recognition.report.run_words import figures, words
from recognition.report.shell import filled, shell, view
from recognition.report.skin_pictures import skin_pictures

_SCRIPTS = ("gl.js", "scene.js", "panels.js", "belief.js", "theme.js", "main.js")
_LAYERS = (
    ("model", "Model"),
    ("off", "Deviation"),
    ("truth", "Truth"),
    ("contacts", "Contacts"),
    ("traces", "Traces"),
    ("pad", "Pad"),
)
_HIDDEN = ("off", "truth")  # layers that are not shown until asked for
_BELIEFS = (
    "<div data-belief hidden><h2>Belief</h2>"
    '<canvas id="beliefs" role="img" aria-label="Probability of objects over time"></canvas></div>'
)
_NAMES = (
    '<div data-belief hidden><h2>Belief</h2><ol id="names" class="names"></ol>'
    '<p id="felt" class="felt" aria-live="off"></p></div>'
)
_NO_POINTS = np.empty((0, 3))
_NOTHING = RunReport({}, {}, None, _NO_POINTS, np.empty(0, dtype=np.int64), EMPTY_FRAMES, (1, 1), (1, 1, 1))


def write_report(path: Path, report: RunReport) -> None:
    """Write the page of one run."""
    path.write_text(report_html(report), encoding="utf-8")


def report_html(report: RunReport) -> str:
    """The page as text."""
    summary = report.summary
    opened, told = tables.without_body(summary) or report.model is None, words(summary)
    present = {
        "model": report.model is not None,
        "off": report.off is not None,
        "truth": report.truth is not None,
        "contacts": len(report.contacts) > 0,
        "traces": len(report.traces) > 0,
        "pad": len(report.frames.times) > 0,
    }
    layers = [
        _layer(name, told.model(summary) if name == "model" else label, _shown(name, opened))
        for name, label in _LAYERS
        if present[name]
    ]
    footer = (
        f"palpate {summary.get('version', '')}, seed {summary.get('seed', '')}. Lengths in mm, world frame."
    )
    return shell(
        title=escape(str(summary.get("part") or "a touched object")),
        lede=told.lede(summary),
        figures=figures(summary),
        main=_stage(report, layers, tables.legend(summary, present["traces"]))
        + tables.section("Flat faces, as the skin saw them", skin_pictures(report.pictures))
        + tables.sections(summary, report.settings, left_out(report), told.sections(summary)),
        footer=escape(footer),
        scripts=_SCRIPTS,
        data=payload(report),
    )


def live_html() -> str:
    """The page of a run that goes on: it begins empty, and asks the server that it came from for more."""
    layers = [_layer(name, label, True) for name, label in _LAYERS if name not in _HIDDEN]
    return shell(
        title="Live",
        lede="starting",
        figures="",
        main=_stage(_NOTHING, layers, ""),
        footer="Lengths in mm, world frame.",
        scripts=(*_SCRIPTS, "live.js"),
        data=payload(_NOTHING),
        asks=True,
    )


def _stage(report: RunReport, layers: list[str], legend: str) -> str:
    return filled(
        "run_stage.html",
        view=view("the reconstructed model", "".join(layers), plays=True),
        legend=legend,
        beliefs=_BELIEFS,
        names=_NAMES,
        off="" if report.off is None else _off_key(report.off.scale),
    )


def _shown(name: str, opened: bool) -> bool:
    return name not in _HIDDEN or (name == "truth" and opened)


def _off_key(scale: float) -> str:
    return (
        '<div id="off-ramp" hidden><h2>Off the truth</h2>'
        f'<p class="ramp off"><span>{scale:g} mm inside</span><i></i><span>{scale:g} mm outside</span></p></div>'
    )


def _layer(name: str, label: str, shown: bool) -> str:
    checked = " checked" if shown else ""
    return f'<label><input type="checkbox" data-layer="{name}"{checked}>{label}</label>'
