"""A boundary as a terminal shows it: size and symmetry, its faces with their neighbors, its edges by kind."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from recognition.report import boundary_words as words
from recognition.report.boundary_words import Json

COLORS = {  # near the page's, in the terminal's 256
    "plane": "color(110)",
    "cylinder": "color(179)",
    "cone": "color(130)",
    "sphere": "color(29)",
    "torus": "color(97)",
    "freeform": "color(250)",
}
_MOST = 100  # rows of faces; the largest stay


def print_boundary(summary: Json) -> None:
    """Print what `library show` found; on a pipe as plain text, wide enough for whole rows."""
    console = Console(highlight=False)
    if console.is_terminal:
        _print(summary, console)
        return
    pipe = Console(highlight=False, width=160)
    with pipe.capture() as captured:
        _print(summary, pipe)
    pipe.file.write("".join(f"{line.rstrip()}\n" for line in captured.get().splitlines()))


def _print(summary: Json, console: Console) -> None:
    faces = sorted(summary["faces"], key=lambda face: -face["area_mm2"])[:_MOST]
    columns = _WIDE if console.width >= _WIDE_ENOUGH else _NARROW
    console.print(_head(summary))
    console.print(_faces(summary, sorted(faces, key=lambda face: int(face["id"])), columns))
    left = len(summary["faces"]) - len(faces)
    if left:
        console.print(f"and {left} smaller faces; --json lists all", style="dim")
    if columns is _NARROW:
        console.print(
            "in: hollow, with the material outside; a wider terminal says what extents mean", style="dim"
        )
    console.print("meets: 3 at a convex edge, [3] at a concave one, (3) smoothly\n", style="dim")
    if summary["edges"]:
        console.print(_edges(summary))
    for warning in summary["warnings"]:
        console.print(Text(f"warning: {warning}", style="yellow"))


def _head(summary: Json) -> Text:
    size = " × ".join(f"{x:.2f}".rstrip("0").rstrip(".") for x in summary["extent_mm"])
    unassigned, freeform = summary["unassigned_area_fraction"], summary["freeform_area_fraction"]
    told = [
        f"{size} mm",
        f"{summary['volume_mm3']:.0f} mm³",
        f"{summary['area_mm2']:.0f} mm²",
        f"symmetry {summary['symmetry'] or 'unknown'}",
        "watertight" if summary["watertight"] else "not watertight",
        *([f"{100 * freeform:.2g} % of the area freeform"] if freeform > 0 else []),
        *([f"{100 * unassigned:.2g} % of the area unassigned"] if unassigned > 0 else []),
    ]
    text = Text(str(summary["name"]), style="bold")
    text.append("\n" + ", ".join(told), style="not bold")
    faces, edges = len(summary["faces"]), len(summary["edges"])
    text.append(
        f"\n{_many(faces, 'face')} ({words.counted(summary)}), {_many(edges, 'edge')}\n", style="not bold"
    )
    return text


def _faces(summary: Json, faces: list[Any], columns: tuple[Column, ...]) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="dim")
    for title, number, _ in columns:
        table.add_column(title, justify="right" if number else "left", no_wrap=True)
    table.add_column("meets")
    meets = words.neighbors(summary)
    for face in faces:
        row = [cell(face) for _, _, cell in columns]
        table.add_row(*row, _meets(meets.get(int(face["id"]), {})))
    return table


def _shape(face: Json) -> Text:
    return Text.assemble(("■ ", COLORS[face["shape"]]), str(face["shape"]))


def _shape_and_side(face: Json) -> Text:
    return _shape(face) + Text(" in" if words.side(face) == "inside" else "")


def _short_axis(face: Json) -> str:
    axis = words.axis(face)
    return "tilted" if "," in axis else axis


Column = tuple[str, bool, Callable[[Json], str | Text]]  # title, whether a number, the cell
_FACE: Column = ("face", True, lambda face: str(face["id"]))
_AREA: Column = ("area, mm²", True, lambda face: f"{face['area_mm2']:.1f}")
_WIDE: tuple[Column, ...] = (
    _FACE,
    ("shape", False, _shape),
    ("side", False, words.side),
    ("extent, mm", False, words.extent),
    ("size, mm", False, words.sizes),
    ("axis", False, words.axis),
    _AREA,
)
_NARROW: tuple[Column, ...] = (
    _FACE,
    ("shape", False, _shape_and_side),
    ("extent, mm", False, lambda face: " × ".join(f"{x:.2f}" for x in face["extent_mm"])),
    ("size, mm", False, lambda face: words.sizes(face, 2)),
    ("axis", False, _short_axis),
    _AREA,
)
_WIDE_ENOUGH = 130  # [columns]


def _meets(others: dict[int, str]) -> Text:
    marks = {"convex": "{}", "concave": "[{}]", "smooth": "({})"}
    return Text(" ".join(marks[kind].format(other) for other, kind in sorted(others.items())))


def _edges(summary: Json) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="dim", title_justify="left")
    table.add_column("edges")
    table.add_column("curve")
    table.add_column("count", justify="right")
    table.add_column("length, mm", justify="right")
    for kind, curve, count, length in words.edge_kinds(summary["edges"]):
        table.add_row(kind, curve, str(count), f"{length:.1f}")
    return table


def _many(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
