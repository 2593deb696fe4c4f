"""What a run came to, in the words of its command: the line under the title, the large numbers, its own tables."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np

from recognition.report import tables
from recognition.report.ended import ended_words
from recognition.report.tables import Column, Json

Cells = Iterable[tuple[str, Any, str]]  # name, value, unit
UNKNOWN = "unknown"


@dataclass(frozen=True)
class Words:
    """How one command's page reads."""

    lede: Callable[[Json], str]
    figures: Callable[[Json], Cells]
    sections: Callable[[Json], str]
    model: Callable[[Json], str]  # what the drawn model is


def words(summary: Json) -> Words:
    """Of the command that made the summary; exploration's where it is none of its own."""
    return _WORDS.get(str(summary.get("command")), _BOUNDARY)


def figures(summary: Json) -> str:
    """The large numbers under the title: what it cost, and what came of it."""
    if _of_a_cloud(summary):
        sigma = _rounded(summary.get("contact_sigma_mm"), 4)
        given: list[tuple[str, Any, str]] = [
            ("Contacts", summary.get("contacts"), ""),
            ("Scatter, 1 sigma", sigma, "mm"),
        ]
        return tables.figure_cells([*given, *words(summary).figures(summary)])
    cost = [
        ("Touches", summary.get("touches"), ""),
        ("Strokes", summary.get("strokes"), ""),
        ("Frames", summary.get("frames"), ""),
        ("Travel", _rounded(summary.get("travel_mm"), 0), "mm"),
        ("Device time", _rounded(summary.get("device_seconds"), 1), "s"),
    ]
    return tables.figure_cells([*cost, *words(summary).figures(summary)])


def _boundary_lede(s: Json) -> str:
    """How it ended, and why there is no body where there is none."""
    state = "closed" if s.get("closed") else "open"
    ended = str(s.get("ended") or state)
    tail = "" if ended == state else f" It ended: {escape(ended_words(ended))}."
    if tables.without_body(s):
        told = [str(w) for w in s.get("warnings") or [] if str(w).startswith("no closed body")]
        tail += "".join(f" There is {escape(text)}." for text in told[:1])
    faces, edges = s.get("faces") or [], s.get("edges") or []
    counted = f"{_many(len(faces), 'face')}, {_many(len(edges), 'edge')}"
    return f'Boundary <span class="state {state}">{state}</span>: {counted}, {_felt_with(s)}.{tail}'


def _boundary_figures(s: Json) -> Cells:
    truth = s.get("truth") or {}
    return [
        ("Volume", _rounded(s.get("volume_mm3"), 0), "mm³"),
        ("Surface error, rms", _rounded(truth.get("surface_rms_mm"), 4), "mm"),
        ("Overlap with truth", _rounded(truth.get("iou"), 4), ""),
    ]


def _boundary_sections(s: Json) -> str:
    return "".join(
        [
            tables.section("Faces", tables.table(s.get("faces") or [], tables.FACES, face_rows=True)),
            tables.section("Edges", tables.table(s.get("edges") or [], tables.EDGES)),
            tables.section("Primitives", tables.table(s.get("primitives") or [], tables.PRIMITIVES)),
            tables.section("Regularities", tables.table(s.get("regularities") or [], tables.REGULARITIES)),
        ]
    )


def _identified_lede(s: Json) -> str:
    objects = (s.get("library") or {}).get("objects", 0)
    decision, share = s.get("decision"), float(s.get("confidence") or 0.0)
    verdict = ""
    if truth := s.get("truth"):
        state, word = ("measured", "right") if truth.get("correct") else ("unknown", "wrong")
        verdict = f' That is <span class="state {state}">{word}</span>.'
        if not truth.get("correct"):
            verdict += f" It is {escape(str(truth.get('name')))}."
    if decision is None or s.get("met") == 0:
        told, verdict = "Nothing was met in the workspace", ""
    elif decision == UNKNOWN:
        told = f"None of the library's {objects} objects, {share:.1%} sure"
    else:
        told = f"It is <strong>{escape(str(decision))}</strong>, {share:.1%} sure, among {objects} objects"
    ended = str(s.get("ended") or "")
    tail = "" if ended in ("", "sure") else f" It ended: {escape(ended_words(ended))}."
    return f"{told}, {_felt_with(s)}.{verdict}{tail}"


def _identified_figures(s: Json) -> Cells:
    truth = s.get("truth") or {}
    return [
        ("Confidence", _rounded(100 * float(s.get("confidence") or 0.0), 1), "%"),
        ("Place off by", _rounded(truth.get("translation_error_mm"), 3), "mm"),
        ("Attitude off by", _rounded(truth.get("rotation_error_deg"), 2), "°"),
    ]


def _identified_sections(s: Json) -> str:
    why = s.get("why") or {}
    contacts = why.get("separating_contacts") or []
    told = ""
    if why.get("runner_up") and contacts:
        numbers = ", ".join(map(str, contacts))
        told = f"<p>Not {escape(str(why['runner_up']))}: contacts {numbers} of contacts.csv speak against it.</p>"
    return "".join(
        [
            tables.section("Candidates", tables.table(s.get("candidates") or [], _CANDIDATES) + told),
            tables.section("Touches", tables.table(s.get("history") or [], _TOUCHES)),
        ]
    )


def _traced_lede(s: Json) -> str:
    what, trace = s.get("what") or s.get("procedure") or "contact", s.get("trace")
    state = "lost" if s.get("lost") else "closed" if s.get("closed") else "ended"
    color = {"lost": "unknown", "closed": "closed"}.get(state, "")
    return (
        f'{escape(str(what)).capitalize()}: <span class="state {color}">{state}</span>, {_felt_with(s)}, '
        f"{_many(0 if trace is None else len(trace), 'point')}."
    )


def _traced_figures(s: Json) -> Cells:
    truth, force = s.get("truth") or {}, s.get("force_n") or {}
    return [
        ("Off the truth, rms", _rounded(truth.get("rms_mm"), 3), "mm"),
        ("Off the truth, most", _rounded(truth.get("max_mm"), 3), "mm"),
        ("Force, mean", _rounded(force.get("mean"), 2), "N"),
    ]


def _traced_sections(s: Json) -> str:
    found = s.get("found") or {}
    rows = [{"number": k, **edge} for k, edge in enumerate(found.get("edges") or [])]
    told = {k: v for k, v in found.items() if not isinstance(v, list | np.ndarray) or len(v) <= _SHORT}
    told.pop("edges", None)
    return "".join(
        [
            tables.section("Edges", tables.table(rows, _TRACED_EDGES)),
            f'<div class="pair">{tables.section("Found", tables.pairs(told))}</div>',
        ]
    )


def _of_a_cloud(s: Json) -> bool:
    """Whether all that there was were contacts, and no run."""
    return s.get("command") == "reconstruct" and not s.get("frames")


def _felt_with(s: Json) -> str:
    if _of_a_cloud(s):
        return f"from {_many(int(s.get('contacts') or 0), 'contact')}"
    arrays = str(s.get("sensor") or "a tactile array").split(",")
    return f"felt with {escape(' and '.join(array.strip() for array in arrays))}"


def _rounded(value: Any, digits: int) -> str | None:
    return None if value is None else f"{value:.{digits}f}"


def _many(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def _share(value: Any) -> str:
    if value is None:
        return ""
    return f'{100 * value:.2f} %<i class="bar" style="width: {100 * value:.0f}px"></i>'


def _likeliest(step: Json) -> str:
    return ", ".join(
        f"{escape(str(name))} {100 * share:.0f} %" for name, share in (step.get("top") or [])[:3]
    )


def _sigma(row: Json, key: str, digits: int) -> str:
    return _rounded((row.get("pose_sigma") or {}).get(key), digits) or ""


def _with_sigma(row: Json, key: str, sigma: str) -> str:
    value = row.get(key)
    if value is None:
        return ""
    return f"{value:.2f}" + (f" <small>± {row[sigma]:.2g}</small>" if row.get(sigma) is not None else "")


_SHORT = 6  # points or numbers that a line of a table holds
_TRACED_EDGES: tuple[Column, ...] = (
    ("Edge", True, lambda e: str(e["number"])),
    ("Curve", False, lambda e: escape(str(e.get("curve") or ""))),
    ("Length, mm", True, lambda e: _rounded(e.get("length_mm"), 2) or ""),
    ("Radius, mm", True, lambda e: _rounded(e.get("radius_mm"), 2) or ""),
    ("Dihedral, °", True, lambda e: _rounded(e.get("dihedral_deg"), 1) or ""),
    ("Rounding, mm", True, lambda e: _with_sigma(e, "rounding_mm", "rounding_sigma_mm")),
    ("Off its curve, rms, mm", True, lambda e: _rounded(e.get("rms_mm"), 3) or ""),
)
_CANDIDATES: tuple[Column, ...] = (
    ("Object", False, lambda c: escape(str(c.get("name")))),
    ("Probability", False, lambda c: _share(c.get("probability"))),
    ("Place ±, mm", True, lambda c: _sigma(c, "translation_mm", 3)),
    ("Attitude ±, °", True, lambda c: _sigma(c, "rotation_deg", 2)),
    ("Contacts off by, mm", True, lambda c: _rounded(c.get("residual_mm"), 3) or ""),
    ("Symmetry", False, lambda c: escape(str(c.get("symmetry") or "")).replace("_inf", "∞")),
)
_TOUCHES: tuple[Column, ...] = (
    ("Touch", True, lambda h: str(h.get("touch"))),
    ("Felt", False, lambda h: escape(str(h.get("felt") or ""))),
    ("Likeliest", False, _likeliest),
    ("Open, bits", True, lambda h: _rounded(h.get("entropy_bits"), 2) or ""),
    ("Expected, bits", True, lambda h: _rounded(h.get("expected_bits"), 2) or ""),
    ("Device time, s", True, lambda h: _rounded(h.get("device_seconds"), 1) or ""),
)


def _drawn(s: Json) -> str:
    return "Felt faces" if tables.without_body(s) else "Model"


_BOUNDARY = Words(_boundary_lede, _boundary_figures, _boundary_sections, _drawn)
_IDENTIFIED = Words(_identified_lede, _identified_figures, _identified_sections, lambda s: "Decided for")
_TRACED = Words(_traced_lede, _traced_figures, _traced_sections, lambda s: "Model")
_WORDS = {"identify": _IDENTIFIED, "track": _TRACED, "probe": _TRACED}
