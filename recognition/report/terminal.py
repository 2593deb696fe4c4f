"""A run as a terminal shows it: a moving line while it goes on, a short account when it has ended."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from recognition.progress import Progress

Watcher = Callable[[Progress], None]


@contextmanager
def watching(quiet: bool = False) -> Iterator[Watcher]:
    """Something to tell progress to; it draws on stderr, and only where that is a terminal."""
    from rich.console import Console

    console = Console(stderr=True, highlight=False)
    if quiet or not console.is_terminal:
        yield lambda _: None
        return
    with console.status("starting") as status:
        yield lambda progress: status.update(_progress_text(progress))


def summary_text(summary: Mapping[str, Any]) -> str:
    """What `explore` prints: how it ended, what it found, how true that is, where the report lies."""
    s = summary
    lines = [
        f"{s['part']}: {s.get('ended', 'ended')} after {s['touches']} touches, {s.get('strokes', 0)} strokes, "
        f"{s['frames']} frames, {s['travel_mm']:.0f} mm of travel, {s['device_seconds']:.1f} s on the device "
        f"({s['wall_seconds']:.1f} s here)"
    ]
    faces = [
        {
            "face": f["id"],
            "shape": f["shape"],
            "status": f["status"],
            "extent_mm": " x ".join(f"{x:.2f}" for x in f.get("extent_mm") or []),
            "radius_mm": _number((f.get("parameters") or {}).get("radius_mm")),
        }
        for f in s.get("faces", [])
    ]
    if faces:
        lines += ["", table_text(faces)]
    if s.get("primitives"):
        lines += ["", "as CSG: " + ", ".join(_primitive_text(p) for p in s["primitives"])]
    if truth := s.get("truth"):
        named = {
            "surface_rms_mm": "surface rms",
            "hausdorff_mm": "Hausdorff",
            "iou": "IoU",
            "face_shape_accuracy": "face shapes right",
        }
        lines.append(
            "against the truth: "
            + ", ".join(f"{word} {_number(truth[key])}" for key, word in named.items() if key in truth)
        )
    lines += [f"warning: {warning}" for warning in s.get("warnings", [])]
    if report := (s.get("files") or {}).get("report"):
        lines += ["", f"report: {report}"]
    return "\n".join(lines)


def table_text(rows: Sequence[Mapping[str, object]]) -> str:
    """Rows as columns of text; numbers to the right."""
    if not rows:
        return "none"
    names = list(rows[0])
    cells = [names, *([_cell(row[name]) for name in names] for row in rows)]
    widths = [max(len(line[i]) for line in cells) for i in range(len(names))]
    right = [_is_number(rows[0][name]) for name in names]
    return "\n".join(
        "  ".join(
            cell.rjust(width) if to_right else cell.ljust(width)
            for cell, width, to_right in zip(line, widths, right, strict=True)
        ).rstrip()
        for line in cells
    )


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _cell(value: object) -> str:
    if isinstance(value, Sequence) and not isinstance(value, str):
        return " x ".join(_number(item) for item in value)
    return _number(value)


def _number(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _primitive_text(primitive: Mapping[str, Any]) -> str:
    sign = "- " if primitive.get("operation") == "subtract" else ""
    return f"{sign}{primitive['kind']} " + " x ".join(f"{x:.2f}" for x in primitive.get("extent_mm") or [])


def _progress_text(p: Progress) -> str:
    parts = [f"{p.phase}: {p.touches} touches, {p.frames} frames, {p.travel:.0f} mm"]
    if p.open:
        parts.append(f"{p.open} open")
    return ", ".join([*parts, p.note] if p.note else parts)
