"""Writes the page of commands from the command line, and draws the pictures of `docs/concepts.md`: `make docs`."""

from pathlib import Path
from typing import Any

import numpy as np
import typer

from exploration.devices.simulated import simulate
from exploration.sensing.calibration import Calibration, correct
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.hough import find_lines
from exploration.sensing.spec import load_sensor
from models.csg import Csg, Cube, Sphere
from models.solid import Solid
from primitives.pose import pose, rotation_exp
from recognition.cli import app

DOCS = Path(__file__).parents[1]
HEAD = """# Commands

`make docs` writes this page from what the commands say of themselves. Lengths are mm; a part is a built-in name
or a CAD file. `--json` prints one JSON object on standard output and nothing else there. Exit codes: 0 done, 1 a
known error, said in one line that names the fix, 2 wrong flags.
"""
_TAXEL = 22  # [px]
_RAMP = np.array([[239, 236, 230], [185, 211, 211], [106, 165, 172], [43, 107, 124], [15, 51, 71]])


def main() -> None:
    """Write the page and the pictures."""
    (DOCS / "commands.md").write_text(commands_page(), encoding="utf-8")
    pictures = DOCS / "pictures"
    pictures.mkdir(exist_ok=True)
    for name, drawn in frames().items():
        (pictures / f"{name}.svg").write_text(drawn, encoding="utf-8")
    (pictures / "belief.svg").write_text(belief_svg(), encoding="utf-8")


def commands_page() -> str:
    """Every command with its arguments and flags."""
    pieces = [HEAD]
    for name, command in _leaves(typer.main.get_command(app)):
        pieces.append(f"\n## palpate {name}\n\n{_plain(command.help)}\n")
        options = [_row(parameter) for parameter in command.params if not getattr(parameter, "hidden", False)]
        told = [row for row in options if row]
        if told:
            pieces.append("\n| | default | |\n|---|---|---|\n" + "\n".join(told) + "\n")
    return "".join(pieces)


def _leaves(command: Any, name: str = "") -> list[tuple[str, Any]]:
    if not hasattr(command, "commands"):
        return [(name, command)]
    below = command.commands.items()
    return [leaf for child, made in below for leaf in _leaves(made, f"{name} {child}".strip())]


def _row(parameter: Any) -> str:
    told = _cell(getattr(parameter, "help", None) or "")
    if parameter.name == "help":
        return ""
    if parameter.param_type_name == "argument":
        return f"| `{_cell(parameter.metavar or parameter.name.upper())}` | | {told} |"
    words = ", ".join([*parameter.opts, *parameter.secondary_opts])
    value = "" if parameter.is_flag else " " + _cell(parameter.metavar or "VALUE")
    shown = parameter.show_default
    default = shown if isinstance(shown, str) else _default(parameter) if shown else ""
    return f"| `{words}{value}` | {_cell(default)} | {told} |"


def _default(parameter: Any) -> str:
    value = parameter.default
    return "" if value is None or value is False or value == "" or callable(value) else str(value)


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("<", "&lt;").replace("\n", " ")


def _plain(text: str | None) -> str:
    return "\n".join(line.strip() for line in (text or "").strip().splitlines())


def frames() -> dict[str, str]:
    """Three presses of a pad, each with the lines that are found."""
    presses: dict[str, tuple[Csg, float, float]] = {
        "edge": (Cube((80, 80, 20)).at(40, 0, -10), 0.4, 0.0),
        "wall": (Cube((9, 80, 20)).at(0, 0, -10), 1.1, 0.0),
        "ball": (Sphere(25).at(0, 0, -25), 0.0, 0.25),
    }
    return {name: _pressed(tree, turn, deeper) for name, (tree, turn, deeper) in presses.items()}


def _pressed(tree: Csg, turn: float, deeper: float) -> str:
    spec = load_sensor("lts210")
    noisy = spec.electronics.__class__(**{**vars(spec.electronics), "noise": 0.05})
    spec = spec.__class__(**{**vars(spec), "electronics": noisy})
    down = np.diag([1.0, -1.0, -1.0]) @ rotation_exp([0.0, 0.0, turn])
    at = pose(down, [0.0, 0.0, -spec.press_depth - deeper])
    rng = np.random.default_rng(0)
    _, (array,) = simulate(Solid.from_csg(tree, 0.01), [spec], rng, start_pose=at)
    return frame_svg(correct(array.read(), Calibration.nominal(spec), spec.array))


def frame_svg(image: TactileImage) -> str:
    """Taxels in shades of depth, x to the right and y up, with the lines of the frame."""
    depth, (px, py) = image.depth, image.array.pitch
    rows, columns = depth.shape
    width, height = columns * _TAXEL, rows * _TAXEL
    share = np.clip(depth / max(float(np.nanmax(depth)), 1e-9), 0.0, 1.0)
    cells = []
    for r in range(rows):
        for c in range(columns):
            x, y = c * _TAXEL, (rows - 1 - r) * _TAXEL
            size = _TAXEL - 2
            cells.append(
                f'<rect x="{x}" y="{y}" width="{size}" height="{size}" fill="{_color(share[r, c])}"/>'
            )
    for line in find_lines(image):
        way, off = np.array([np.cos(line.angle), np.sin(line.angle)]), line.offset
        middle = np.array([-way[1], way[0]]) * off
        ends = [(middle + s * 200.0 * way) / [px, py] * _TAXEL for s in (-1.0, 1.0)]
        (x0, y0), (x1, y1) = [(width / 2 + e[0], height / 2 - e[1]) for e in ends]
        cells.append(
            f'<line x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}" stroke="#c4502e" stroke-width="3"/>'
        )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" '
        f'height="{height}">{"".join(cells)}</svg>\n'
    )


def belief_svg() -> str:
    """Probabilities after each contact of a growing number, of three parts."""
    from models import parts
    from models.library import Library
    from primitives.evidence import Contacts
    from recognition.matching import Evidence, Prior, match

    names = ("block", "bracket", "wedge")
    library = Library.of({name: Solid.from_csg(parts.build(name)) for name in names})
    samples, rng = library["bracket"].samples, np.random.default_rng(4)
    chosen = rng.choice(len(samples.points), 14, replace=False)
    told = []
    for count in range(2, 15, 2):
        rows = chosen[:count]
        points = samples.points[rows] + rng.normal(scale=0.1, size=(count, 3))
        contacts = Contacts.of(points, samples.normals[rows], sigma=0.1)
        told.append((count, match(Evidence(contacts), library, Prior.around(contacts)).probabilities))
    width, height, left, base = 420, 220, 44, 180
    colors = {"bracket": "#2f6f7d", "block": "#c4502e", "wedge": "#8a6410", "unknown": "#6b7178"}
    marks = [
        f'<text x="{left - 6}" y="{base - 150 * s + 4:.0f}" text-anchor="end">{100 * s:.0f} %</text>'
        f'<line x1="{left}" x2="{width - 90}" y1="{base - 150 * s:.0f}" y2="{base - 150 * s:.0f}" stroke="#8884"/>'
        for s in (0.0, 0.5, 1.0)
    ]
    for k, (name, color) in enumerate(colors.items()):
        path = " ".join(
            f"{left + (count - 2) * 23.8:.1f},{base - 150 * p.get(name, 0.0):.1f}" for count, p in told
        )
        marks.append(f'<polyline points="{path}" fill="none" stroke="{color}" stroke-width="2.2"/>')
        marks.append(f'<text x="{width - 82}" y="{40 + 20 * k}" style="fill: {color}">{name}</text>')
    marks += [
        f'<text x="{left + (c - 2) * 23.8:.1f}" y="{base + 16}" text-anchor="middle">{c}</text>'
        for c, _ in told
    ]
    marks.append(
        f'<text x="{(left + width - 90) / 2:.0f}" y="{height - 6}" text-anchor="middle">contacts</text>'
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" '
        f'height="{height}" font-family="system-ui, sans-serif" font-size="12" fill="#777">'
        f"{''.join(marks)}</svg>\n"
    )


def _color(share: float) -> str:
    at = min(float(share) * 4.0, 3.999)
    k = int(at)
    mixed = _RAMP[k] + (_RAMP[k + 1] - _RAMP[k]) * (at - k)
    return "#" + "".join(f"{round(float(x)):02x}" for x in mixed)


if __name__ == "__main__":
    main()
