"""The page of one model's boundary: one HTML file that needs nothing else, with the run page's view and look."""

from __future__ import annotations

from html import escape
from typing import Any

import numpy as np

from models.brep import Brep
from recognition.report import boundary_words as words
from recognition.report import tables
from recognition.report.boundary_words import Json
from recognition.report.face_graph import graph_svg
from recognition.report.payload import packed, payload
from recognition.report.run_report import EMPTY_FRAMES, ReportMesh, RunReport
from recognition.report.shell import filled, shell, view

_SCRIPTS = ("gl.js", "scene.js", "panels.js", "theme.js", "boundary.js")
_LONG = 40  # rows of edges; more are folded away
_NO_POINTS = np.empty((0, 3))


def boundary_html(summary: Json, brep: Brep, mesh: ReportMesh) -> str:
    """The page as text; the mesh's faces are those of the boundary."""
    return shell(
        title=escape(str(summary["name"])),
        lede=_lede(summary, brep),
        figures=_figures(summary, brep),
        main=filled(
            "boundary_stage.html",
            view=view("the model, faces colored by shape"),
            graph=graph_svg(summary),
            legend=_legend(summary),
        )
        + _sections(summary),
        footer="Lengths in mm, in the part's own frame.",
        styles=("boundary.css",),
        scripts=_SCRIPTS,
        data=_data(summary, brep, mesh),
    )


def _data(summary: Json, brep: Brep, mesh: ReportMesh) -> dict[str, Any]:
    """What the page's script unpacks: a run's payload without frames, its edges the exact ones."""
    empty = RunReport(
        summary, {}, mesh, _NO_POINTS, np.empty(0, dtype=np.int64), EMPTY_FRAMES, (1, 1), (1, 1, 1)
    )
    out = payload(empty)
    plain = [edge.points for edge in brep.edges if edge.kind != "concave"]
    inside = [edge.points for edge in brep.edges if edge.kind == "concave"]
    return out | {
        "model": out["model"] | {"edges": packed(_segments(plain), "f4")},
        "traces": {"segments": packed(_segments(inside), "f4"), "from": packed([], "i4")},
    }


def _segments(runs: list[Any]) -> Any:
    pieces = [np.empty((0, 2, 3)), *(np.stack([run[:-1], run[1:]], axis=1) for run in runs)]
    return np.concatenate(pieces)


def _lede(summary: Json, brep: Brep) -> str:
    kinds = [kind for kind in words.KINDS if any(e["kind"] == kind for e in summary["edges"])]
    edges = ", ".join(f"{sum(e['kind'] == kind for e in summary['edges'])} {kind}" for kind in kinds)
    shells = "" if brep.shells == 1 else f" {brep.shells} shells."
    handles = (
        "" if brep.genus == 0 else f" {brep.genus} {'hole goes' if brep.genus == 1 else 'holes go'} through."
    )
    return f"{escape(words.counted(summary))}.{f' Edges: {edges}.' if edges else ''}{shells}{handles}"


def _figures(summary: Json, brep: Brep) -> str:
    unassigned = 100 * summary["unassigned_area_fraction"]
    freeform = 100 * summary["freeform_area_fraction"]
    return tables.figure_cells(
        [
            ("Size", " × ".join(f"{x:.1f}".removesuffix(".0") for x in summary["extent_mm"]), "mm"),
            ("Volume", f"{summary['volume_mm3']:.0f}", "mm³"),
            ("Area", f"{summary['area_mm2']:.0f}", "mm²"),
            ("Faces", len(summary["faces"]), ""),
            ("Edges", len(summary["edges"]), ""),
            ("Vertices", len(brep.vertices), ""),
            ("Symmetry", _group(summary["symmetry"]), ""),
            ("Watertight", "yes" if summary["watertight"] else "no", ""),
            ("Freeform", f"{freeform:.2g}", "%"),
            ("Unassigned", f"{unassigned:.2g}", "%"),
        ]
    )


def _group(name: str | None) -> str | None:
    return None if name is None else name.replace("_inf", "∞")


def _legend(summary: Json) -> str:
    present = {str(face["shape"]) for face in summary["faces"]}
    counts = {s: sum(face["shape"] == s for face in summary["faces"]) for s in present}
    items = [
        f"<li>{tables.swatch(s)}{s} <small>{counts[s]}</small></li>" for s in words.SHAPES if s in present
    ]
    kinds = {str(edge["kind"]) for edge in summary["edges"]}
    items += [
        f'<li><span class="stroke {kind}"></span>{kind} edge</li>' for kind in words.KINDS if kind in kinds
    ]
    return "".join(items)


def _sections(summary: Json) -> str:
    listed = "".join(f"<li>{escape(str(warning))}</li>" for warning in summary["warnings"])
    meets = words.neighbors(summary)
    faces = [dict(face) | {"meets": meets.get(int(face["id"]), {})} for face in summary["faces"]]
    return "".join(
        [
            tables.section("Warnings", f'<ul class="warnings">{listed}</ul>' if listed else ""),
            tables.section("Faces", tables.table(faces, _FACES, face_rows=True)),
            tables.section("Edges", _folded(tables.table(summary["edges"], _EDGES), len(summary["edges"]))),
        ]
    )


def _folded(table: str, rows: int) -> str:
    """A long table behind a line that opens it."""
    if rows <= _LONG:
        return table
    return f"<details><summary>{rows} edges</summary>{table}</details>"


def _meets(others: dict[int, str]) -> str:
    return " ".join(f'<span class="{kind}">{other}</span>' for other, kind in sorted(others.items()))


_FACES: tuple[tables.Column, ...] = (
    ("Face", True, lambda f: str(int(f["id"]))),
    ("Shape", False, lambda f: tables.swatch(str(f["shape"])) + escape(str(f["shape"]))),
    ("Side", False, lambda f: words.side(f)),
    ("Extent, mm", False, lambda f: escape(words.extent(f))),
    ("Size, mm", False, lambda f: escape(words.sizes(f))),
    ("Axis", False, lambda f: escape(words.axis(f))),
    ("Area, mm²", True, lambda f: f"{f['area_mm2']:.1f}"),
    ("Meets", False, lambda f: _meets(f["meets"])),
)
_EDGES: tuple[tables.Column, ...] = (
    ("Edge", True, lambda e: str(int(e["id"]))),
    ("Between faces", False, lambda e: " and ".join(str(face) for face in e["faces"])),
    ("Kind", False, lambda e: f'<span class="{escape(e["kind"])}">{escape(e["kind"])}</span>'),
    ("Curve", False, lambda e: escape(str(e["curve"]))),
    ("Length, mm", True, lambda e: f"{e['length_mm']:.2f}"),
    ("Dihedral, °", True, lambda e: f"{e['dihedral_deg']:.2f}"),
)
