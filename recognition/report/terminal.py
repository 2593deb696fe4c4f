"""A run as a terminal shows it: a moving line while it goes on, a short account when it has ended."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from recognition.report.ended import ended_words
from recognition.running.progress import Progress

_TRUTH = (
    ("surface_rms_mm", "surface rms", " mm"),
    ("hausdorff_mm", "Hausdorff", " mm"),
    ("iou", "IoU", ""),
    ("face_shape_accuracy", "share of faces right", ""),
)


class Watch:
    """Takes progress, shows it, and remembers where the run is written; `say` is for a line that stays."""

    def __init__(self, show: Callable[[str], object], say: Callable[[str], object]) -> None:
        self.folder: Path | None = None
        self.say = say
        self._show = show

    def __call__(self, progress: Progress) -> None:
        """Show where the run stands."""
        self.folder = progress.folder or self.folder
        self._show(progress_text(progress))


@contextmanager
def watching(quiet: bool = False) -> Iterator[Watch]:
    """Something to tell progress to; it draws on stderr, and only where that is a terminal."""
    from rich.console import Console

    console = Console(stderr=True, highlight=False, soft_wrap=True, markup=False)

    def say(text: str) -> None:
        console.print(f"palpate: {text}")

    if quiet or not console.is_terminal:
        yield Watch(lambda _: None, say)
        return
    with console.status("starting") as status:
        yield Watch(lambda text: status.update(text[: console.width - 4]), say)


def summary_text(summary: Mapping[str, Any], folder: Path | None = None) -> str:
    """What `explore` prints: how it ended, what it found, how true that is, where the report lies."""
    s = summary
    ended = "closed" if s["closed"] else f"not closed ({ended_words(str(s.get('ended') or 'open'))})"
    lines = [
        f"{s['part']}: {ended} after {_many(s['touches'], 'touch', 'touches')}, "
        f"{_many(s.get('strokes', 0), 'stroke')}, {_many(s['frames'], 'frame')}",
        f"{s['travel_mm']:.0f} mm of travel in {s['device_seconds']:.1f} s on the device, "
        f"{s['wall_seconds']:.1f} s here",
    ]
    if s.get("faces"):
        lines += ["", table_text(_with_something([_face_row(face) for face in s["faces"]]))]
    if s.get("primitives"):
        lines += ["", "as CSG: " + _csg_text(s["primitives"])]
    if truth := s.get("truth"):
        told = [
            f"{word} {_number(truth[key])}{unit}" for key, word, unit in _TRUTH if truth.get(key) is not None
        ]
        lines += ["against the truth: " + ", ".join(told)] if told else []
    if s.get("warnings"):
        lines += ["", *(f"warning: {warning}" for warning in s["warnings"])]
    if report := (s.get("files") or {}).get("report"):
        lines += ["", f"report: {folder / report if folder else report}"]
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


def _face_row(face: Mapping[str, Any]) -> dict[str, object]:
    parameters, sigma = face.get("parameters") or {}, face.get("sigma") or {}
    row: dict[str, object] = {
        "face": face["id"],
        "shape": face["shape"],
        "status": face["status"],
        "extent_mm": " x ".join(f"{x:.2f}" for x in face.get("extent_mm") or []),
    }
    for key in ("radius_mm", "semi_angle_deg"):
        spread = f" +- {sigma[key]:.1g}" if key in sigma else ""
        row[key] = f"{parameters[key]:.3f}{spread}" if key in parameters else ""
    return row


def _with_something(rows: Sequence[Mapping[str, object]]) -> list[dict[str, object]]:
    """The columns in which any row says something."""
    return [{name: row[name] for name in row if any(other[name] != "" for other in rows)} for row in rows]


def _csg_text(primitives: Sequence[Mapping[str, Any]]) -> str:
    signs = {"add": " | ", "subtract": " - ", "intersect": " & "}
    texts = [f"{p['kind']} " + " x ".join(f"{x:.2f}" for x in p.get("extent_mm") or []) for p in primitives]
    joined = [
        signs.get(str(p.get("operation")), ", ") + text for p, text in zip(primitives, texts, strict=True)
    ]
    return "".join(joined).removeprefix(" | ")


def _many(count: int, noun: str, nouns: str = "") -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {nouns or noun + 's'}"


def progress_text(p: Progress) -> str:
    """Where a run stands, in one line."""
    parts = [_many(p.touches, "touch", "touches")] if p.touches or p.frames else []
    parts += [_many(p.frames, "frame"), f"{p.travel:.0f} mm of travel"] if p.frames else []
    parts += [f"{p.open} open"] if p.open else []
    parts += [p.note] if p.note else []
    return f"{p.phase}: {', '.join(parts)}" if parts else p.phase
