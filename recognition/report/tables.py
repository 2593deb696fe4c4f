"""The report's words and tables as HTML, so that they read without a script and on paper."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

Row = Mapping[str, Any]
Column = tuple[str, bool, Callable[[Row], str]]  # title, whether a number, the cell's HTML
Json = Mapping[str, Any]
_UNITS = {
    "mm": "mm",
    "mm/s": "mm/s",
    "mm2": "mm²",
    "mm3": "mm³",
    "deg": "°",
    "seconds": "s",
    "s": "s",
    "n": "N",
}
_NAMES = {"iou": "Overlap (IoU)", "wall": "Time here", "device": "Device time", "frame": "Time of a frame"}


def figure_cells(cells: Iterable[tuple[str, Any, str]]) -> str:
    """Names, values and units as large numbers; those without a value are left out."""
    shown = [
        f"<div><dt>{name}</dt><dd>{escape(_thousands(value))}{_unit(unit)}</dd></div>"
        for name, value, unit in cells
        if value is not None
    ]
    return f'<dl class="figures">{"".join(shown)}</dl>'


def without_body(summary: Json) -> bool:
    """Whether the run was to find a closed body, and did not."""
    return "faces" in summary and not summary.get("closed") and summary.get("csg") is None


def legend(summary: Json, traces: bool) -> str:
    """One swatch per shape that occurs."""
    shapes = dict.fromkeys(str(face["shape"]) for face in summary.get("faces") or [])
    items = [f"<li>{swatch(shape)}{escape(shape)}</li>" for shape in shapes]
    if traces:
        items.append('<li><span class="swatch line"></span>tracked edge</li>')
    return "".join(items)


def sections(summary: Json, settings: Json, notes: Sequence[str], own: str) -> str:
    """Everything below the replay, `own` being the tables of its command."""
    warnings = [*(summary.get("warnings") or []), *notes]
    listed = "".join(f"<li>{escape(str(warning))}</li>" for warning in warnings)
    return "".join(
        [
            section("Warnings", f'<ul class="warnings">{listed}</ul>' if warnings else ""),
            own,
            '<div class="pair">',
            section("Against the truth", pairs(summary.get("truth") or {})),
            section("Settings", pairs(settings)),
            "</div>",
        ]
    )


def section(title: str, body: str) -> str:
    """A titled part of the page; nothing where the body is empty."""
    return f'<section class="table"><h2>{title}</h2>{body}</section>' if body else ""


def table(rows: Iterable[Row], columns: Sequence[Column], face_rows: bool = False) -> str:
    """Rows under the titles of columns that say anything; `face_rows` are marked with their face's id."""
    told = [(row, [cell(row) for _, _, cell in columns]) for row in rows]
    if not told:
        return ""
    shown = [k for k in range(len(columns)) if any(cells[k] for _, cells in told)]
    body = [
        (f'<tr tabindex="0" data-face="{int(row["id"])}">' if face_rows else "<tr>")
        + "".join(f"<td{_align(columns[k][1])}>{cells[k]}</td>" for k in shown)
        + "</tr>"
        for row, cells in told
    ]
    head = "".join(f"<th{_align(columns[k][1])}>{columns[k][0]}</th>" for k in shown)
    label = escape("Table of " + ", ".join(title for title, _, _ in columns[:2]))
    region = f'<div class="scroll" tabindex="0" role="region" aria-label="{label}">'
    return f"{region}<table><thead><tr>{head}</tr></thead><tbody>{''.join(body)}</tbody></table></div>"


def _align(number: bool) -> str:
    return ' class="number"' if number else ""


def pairs(values: Json) -> str:
    """Names and values, one a line."""
    rows = [
        f"<tr><td>{escape(worded(name))}</td><td>{escape(_any(value))}</td></tr>"
        for name, value in _flat(values)
    ]
    return f"<table><tbody>{''.join(rows)}</tbody></table>" if rows else ""


def _flat(values: Json, prefix: str = "") -> Iterable[tuple[str, Any]]:
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{name} ")
        elif value is not None:
            yield prefix + name, value


def worded(name: str) -> str:
    """`surface_rms_mm` as "Surface rms, mm", and `share_within_0_1_mm` as "Share within 0.1 mm"."""
    plain = re.sub(r"(?<=_\d)_(?=\d)", ".", name).replace("_mm_s", "_mm/s")
    words = plain.replace("_", " ").split()
    unit = next((word for k, word in enumerate(words) if word in _UNITS and not _counted(words, k)), None)
    rest = " ".join(word for word in words if word != unit)
    text = _NAMES.get(rest, rest[:1].upper() + rest[1:])
    return f"{text}, {_UNITS[unit]}" if unit else text


def _counted(words: Sequence[str], place: int) -> bool:
    """Whether a unit belongs to the number before it."""
    return place > 0 and words[place - 1].replace(".", "").isdigit()


def _any(value: Any) -> str:
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.5g}"
    if isinstance(value, Mapping):
        return "; ".join(
            f"{worded(str(key))} {_any(item)}" for key, item in value.items() if item is not None
        )
    if isinstance(value, list | tuple):
        joint = "; " if any(isinstance(item, list | tuple | np.ndarray | Mapping) for item in value) else ", "
        return joint.join("–" if item is None else _any(item) for item in value) or "none"
    return str(value)


def _rounded(value: Any, digits: int) -> str | None:
    return None if value is None else f"{value:.{digits}f}"


def _thousands(value: Any) -> str:
    text = str(value)
    whole, dot, rest = text.partition(".")
    return f"{int(whole):,}".replace(",", "\u2009") + dot + rest if whole.isdigit() else text


def _unit(unit: str) -> str:
    return f"<small> {unit}</small>" if unit else ""


def swatch(shape: str) -> str:
    """A small square in the shape's color."""
    return f'<span class="swatch" style="background: var(--{escape(shape)})"></span>'


def _state(row: Row) -> str:
    state = escape(str(row.get("status", "")))
    return f'<span class="state {state}">{state}</span>'


def _lengths(values: Any, digits: int = 2) -> str:
    return " × ".join(f"{x:.{digits}f}" for x in values or [] if x is not None)


def _with_sigma(row: Row, key: str, digits: int) -> str:
    value, sigma = (row.get("parameters") or {}).get(key), (row.get("sigma") or {}).get(key)
    if value is None:
        return ""
    return f"{value:.{digits}f}" + (f" <small>± {sigma:.2g}</small>" if sigma is not None else "")


def _sigma(row: Row, key: str) -> str:
    sigma = (row.get("sigma") or {}).get(key)
    return "" if sigma is None else f"{sigma:.2g}"


def _vector(values: Any, digits: int) -> str:
    return ", ".join(f"{x:.{digits}f}" for x in values or [])


def _radii(row: Row) -> str:
    top, bottom = row.get("top_radius_mm"), row.get("bottom_radius_mm")
    return f" <small>radii {bottom:.2f}, {top:.2f}</small>" if top is not None and bottom is not None else ""


FACES: tuple[Column, ...] = (
    ("Face", True, lambda f: str(int(f["id"]))),
    ("Shape", False, lambda f: swatch(str(f["shape"])) + escape(str(f["shape"]))),
    ("Status", False, _state),
    ("Extent, mm", True, lambda f: _lengths(f.get("extent_mm"))),
    ("Place ±, mm", True, lambda f: _sigma(f, "origin_mm") or _sigma(f, "surface_mm")),
    ("Axis ±, °", True, lambda f: _sigma(f, "axis_deg")),
    ("Radius, mm", True, lambda f: _with_sigma(f, "radius_mm", 3)),
    ("Semi-angle, °", True, lambda f: _with_sigma(f, "semi_angle_deg", 2)),
    ("Axis", True, lambda f: _vector((f.get("parameters") or {}).get("axis"), 3)),
    ("Area, mm²", True, lambda f: _rounded(f.get("area_mm2"), 1) or ""),
)
EDGES: tuple[Column, ...] = (
    ("Edge", True, lambda e: str(int(e["id"]))),
    ("Between faces", False, lambda e: " and ".join(str(face) for face in e.get("faces") or [])),
    ("Kind", False, lambda e: escape(str(e.get("kind", "")))),
    ("Curve", False, lambda e: escape(str(e.get("curve", "")))),
    ("Status", False, _state),
    ("Length, mm", True, lambda e: _rounded(e.get("length_mm"), 2) or ""),
    ("Dihedral, °", True, lambda e: _rounded(e.get("dihedral_deg"), 2) or ""),
)
REGULARITIES: tuple[Column, ...] = (
    ("Kind", False, lambda r: escape(str(r["kind"]))),
    ("Faces", False, lambda r: ", ".join(str(face) for face in r.get("faces") or [])),
    ("Measured", True, lambda r: f"{_rounded(r.get('measured'), 4)} ± {_rounded(r.get('sigma'), 4)}"),
    ("Taken", True, lambda r: f"{float(r.get('taken') or 0.0):g}"),
    ("Unit", False, lambda r: "°" if r.get("unit") == "deg" else "mm"),
)
PRIMITIVES: tuple[Column, ...] = (
    ("Operation", False, lambda p: escape(str(p.get("operation", "")))),
    ("Kind", False, lambda p: escape(str(p["kind"]))),
    ("Extent, mm", True, lambda p: _lengths(p.get("extent_mm")) + _radii(p)),
    ("Center, mm", True, lambda p: _vector((p.get("pose") or {}).get("translation_mm"), 2)),
    ("Quaternion, wxyz", True, lambda p: _vector((p.get("pose") or {}).get("quaternion_wxyz"), 4)),
)
