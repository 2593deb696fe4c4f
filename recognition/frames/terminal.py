"""A recording, or one frame of it, as a terminal shows it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console, Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from recognition.frames.colors import KINDS, Color
from recognition.frames.felt import Feeler, Felt
from recognition.frames.overview import SHOWN, FeltTouch, timeline, touches_of
from recognition.frames.picture_text import taxel_text
from recognition.frames.run import Seen, Tell
from recognition.frames.words import (
    arc_words,
    curvature_words,
    force_words,
    line_words,
    radius_words,
    title,
    unit_of,
    verdict,
)

_HEIGHTS = " ▁▂▃▄▅▆▇█"


@contextmanager
def telling(quiet: bool = False) -> Iterator[Tell]:
    """Something to tell progress to; it draws on stderr, and only where that is a terminal."""
    console = Console(stderr=True, highlight=False)
    if quiet or not console.is_terminal:
        yield lambda *_: None
        return
    with console.status("opening") as status:
        yield lambda phase, done, total: status.update(
            f"{phase} {done} of {total} frames" if total else f"{phase} {done} frames"
        )


@contextmanager
def showing(quiet: bool = False) -> Iterator[Callable[[Felt, Feeler], object]]:
    """Something to show the newest frame of an array to, redrawn in place where stderr is a terminal."""
    console = Console(stderr=True, highlight=False)
    if quiet or not console.is_terminal:
        yield lambda *_: None
        return
    with Live(Text("leave the array untouched for a moment"), console=console, auto_refresh=False) as live:

        def show(felt: Felt, feeler: Feeler) -> None:
            pad, rest = feeler.recording.pads[0], feeler.rests[0]
            color = _style(KINDS[felt.touch.kind])
            lines = [", ".join(line_words(line, unit_of(pad))[:2]) for line in felt.touch.lines]
            live.update(
                Group(
                    taxel_text(felt, pad, rest, console),
                    Text(f"{felt.time:6.1f} s  {verdict(felt)}  {force_words(felt, pad)}", color),
                    Text("; ".join(lines) or "no lines", style="dim"),
                    Text("Ctrl-C ends, and tells what was felt", style="dim"),
                ),
                refresh=True,
            )

        yield show


def print_frames(seen: Seen, one: bool, console: Console | None = None) -> None:
    """All frames in short, or those of one index in full."""
    console = console or Console(highlight=False, soft_wrap=False)
    console.print(_headline(seen), soft_wrap=True)
    if one:
        _print_one(seen, console)
    else:
        _print_all(seen, console)
    for warning in seen.warnings:
        console.print(Text(f"note: {warning}", style="dim"), soft_wrap=True)


def _headline(seen: Seen) -> Text:
    recording = seen.recording
    count = max(seen.feeler.frame_counts)
    pads = len(recording.pads)
    times = [row["time_ms"] for row in seen.rows if isinstance(row["time_ms"], float)]
    span = f", {(max(times) - min(times)) / 1000:.2f} s" if len(times) > 1 else ""
    shapes = sorted({pad.array.shape for pad in recording.pads}, reverse=True)
    size = " and ".join(f"{rows} x {columns}" for rows, columns in shapes)
    out = Text(recording.path.name, style="bold")
    out.append(
        f"  {recording.sensor}, {_many(pads, 'pad')} of {size}, {_many(count, 'frame')}{span}", style=""
    )
    out.append(", with poses" if recording.posed else ", no poses: frames only", style="")
    return out


def _print_all(seen: Seen, console: Console) -> None:
    pads = range(len(seen.recording.pads))
    touches = {pad: touches_of(seen.rows, seen.peaks, pad) for pad in pads}
    width = max(20, min(console.width, 160) - 10)
    console.print()
    for pad in pads:
        if touches[pad]:
            line = Text(f"pad {pad:<3} ", style="dim")
            for kind, peak in timeline(seen.rows, seen.peaks, pad, width):
                height = 0 if kind == "nothing" else max(1, min(8, round(8 * peak)))
                line.append(_HEIGHTS[height] if height else "·", _style(KINDS[kind]))
            console.print(line, soft_wrap=True)
    idle = [str(pad) for pad in pads if not touches[pad]]
    if idle:
        console.print(
            Text(f"{'pad' if len(idle) == 1 else 'pads'} {', '.join(idle)}: nothing felt", style="dim")
        )
    felt = [touch for pad in pads for touch in touches[pad]]
    if not felt:
        return
    legend = Text("        ")
    for kind in KINDS:
        legend.append(f"{'·' if kind == 'nothing' else '█'} ", _style(KINDS[kind]))
        legend.append(f"{kind}  ", "dim")
    console.print(legend, soft_wrap=True)
    console.print()
    longest = sorted(sorted(felt, key=lambda touch: -len(touch.rows))[:SHOWN], key=_place)
    console.print(_touch_table(seen, longest))
    if len(felt) > len(longest):
        console.print(Text(f"and {len(felt) - len(longest)} shorter touches", style="dim"))
    firmest = max(felt, key=lambda touch: touch.peak)
    middle = firmest.rows[len(firmest.rows) // 2]["index"]
    console.print(
        Text(f"one frame in full: palpate frames {seen.recording.path} --index {middle}", style="dim"),
        soft_wrap=True,
    )


def _touch_table(seen: Seen, touches: list[FeltTouch]) -> Table:
    """One row a touch, with the columns in which any row says something."""
    rows = [_touch_cells(touch, unit_of(seen.recording.pads[touch.pad])) for touch in touches]
    table = Table(box=None, pad_edge=False, header_style="dim", padding=(0, 2, 0, 0))
    told = [name for name in rows[0] if any(row[name] for row in rows)]
    for name in told:
        table.add_column(name, justify="right" if name in ("pad", "lines", "arcs", "force") else "left")
    for row in rows:
        table.add_row(*(row[name] for name in told))
    return table


def _touch_cells(touch: FeltTouch, unit: str) -> dict[str, Text]:
    line, curvatures, force = touch.typical_line, touch.curvatures, touch.force
    kinds = (Text(f"{kind} {100 * share:.0f} %", _style(KINDS[kind])) for kind, share in touch.kinds[:3])
    return {
        "pad": Text(str(touch.pad)),
        "frames": Text(f"{touch.rows[0]['index']}-{touch.rows[-1]['index']}"),
        "kinds": Text(", ").join(kinds),
        "lines": Text(str(touch.lines or "")),
        "first line": Text(f"{line[0]:.1f}°, {line[1]:+.2f} {unit}" if line else ""),
        "arcs": Text(str(touch.arcs or "")),
        "curvature": Text(", ".join(map(radius_words, curvatures)) if curvatures else ""),
        "force": Text(f"{force:.2f} N" if force is not None else ""),
    }


def _print_one(seen: Seen, console: Console) -> None:
    idle = []
    for felt in seen.shown:
        pad, rest = seen.recording.pads[felt.pad], seen.feeler.rests[felt.pad]
        if not felt.touch and not felt.unreadable and len(seen.shown) > 1:
            idle.append(str(felt.pad))
            continue
        unit = unit_of(pad)
        console.print()
        console.print(
            Text.assemble((title(felt, pad), "bold"), "  ", (verdict(felt), _style(KINDS[felt.touch.kind])))
        )
        console.print(taxel_text(felt, pad, rest, console), soft_wrap=True)
        others = (f"{kind} {100 * share:.1f} %" for kind, share in felt.touch.kinds.items())
        console.print(Text(", ".join(others), style="dim"), soft_wrap=True)
        for i, line in enumerate(felt.touch.lines):
            angle, offset, length = line_words(line, unit)
            console.print(
                f"line {i}: at {angle}, offset {offset}, {length} seen, material {_side(line.material_side)}"
            )
        for arc in felt.arcs:
            console.print(f"arc: {arc_words(arc, unit)}")
        console.print(f"curvature: {curvature_words(felt, pad)}; force: {force_words(felt, pad)}")
    if idle:
        console.print()
        console.print(Text(f"pads {', '.join(idle)}: nothing felt", style="dim"))


def _place(touch: FeltTouch) -> tuple[int, int]:
    return touch.pad, int(touch.rows[0]["index"])


def _side(side: int) -> str:
    return "on the positive side" if side > 0 else "on the negative side"


def _many(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def _style(color: Color) -> str:
    return f"rgb({color[0]},{color[1]},{color[2]})"
