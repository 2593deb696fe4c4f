"""The live view of a tracker: the frame with its line, force, speed, and what it is doing.

It is drawn on stderr a few times a second of the wall clock, and only where that is a terminal.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from rich.console import Console, Group
from rich.live import Live
from rich.text import Text

from exploration.devices.guard import Observation
from exploration.sensing.lines.hough import sure_lines
from primitives.arrays import Floats
from recognition.frames.colors import HEAT, INK, LINES, Color, heat
from recognition.running.progress import Progress

EVERY = 0.2  # [s] between two pictures
BAR = 30  # characters of the force bar
LEAST_FORCE = 20.0  # [N] at the bar's end, before more was felt
UPPER_HALF = "▀"  # one character shows two taxels
SMOOTHING = 0.2  # share of the newest reading in the speed that is shown


class View:
    """Takes every observation, and draws now and then; without a `live` it draws nothing."""

    def __init__(self, live: Live | None = None, console: Console | None = None) -> None:
        self.folder: Path | None = None
        self._live, self._console = live, console
        self._doing = "starting"
        self._last: Observation | None = None
        self._speed = 0.0
        self._most = LEAST_FORCE
        self._drawn = 0.0

    def say(self, text: str) -> None:
        """A line that stays."""
        if self._console is not None:
            self._console.print(f"palpate: {text}")

    def doing(self, what: str) -> None:
        """Say what goes on now."""
        self._doing = what

    def told(self, progress: Progress) -> None:
        """Remember where the run is written."""
        self.folder = progress.folder or self.folder

    def seen(self, seen: Observation) -> None:
        """One tick."""
        if self._live is None:
            return
        if self._last is not None and seen.time > self._last.time:
            step = seen.world_from_sensor[:3, 3] - self._last.world_from_sensor[:3, 3]
            speed = float(np.linalg.norm(step)) / (seen.time - self._last.time)
            self._speed += SMOOTHING * (speed - self._speed)
        self._last, self._most = seen, max(self._most, seen.force)
        now = time.monotonic()
        if now - self._drawn > EVERY:
            self._drawn = now
            self._live.update(self.picture(seen), refresh=True)

    def picture(self, seen: Observation) -> Group:
        """Taxels with the line over them, force, speed."""
        share = min(1.0, max(0.0, seen.force) / self._most)
        bar = Text("force ", style="dim")
        bar.append("█" * round(BAR * share), style=_rgb(HEAT[3]))
        bar.append("·" * (BAR - round(BAR * share)), style="dim")
        bar.append(f" {seen.force:5.1f} N   ")
        bar.append("speed ", style="dim")
        bar.append(f"{self._speed:5.1f} mm/s   ")
        bar.append("time ", style="dim")
        bar.append(f"{seen.time:.1f} s")
        return Group(Text(self._doing, style="bold"), taxels(seen), bar)


def taxels(seen: Observation) -> Text:
    """Two rows of taxels in a row of characters, row 0 at the bottom, and the line in its color."""
    image = seen.image
    depth = np.where(np.isfinite(image.sigma), image.depth, 0.0)
    shares = np.clip(depth / max(0.5, float(depth.max(initial=0.0))), 0.0, 1.0)
    fine = np.repeat(np.repeat(shares, 2, axis=0), 2, axis=1)[::-1]
    on = np.zeros(fine.shape, dtype=bool)
    for line in sure_lines(image, 1):
        on |= _along(line.offset * line.normal, line.direction, np.asarray(image.array.size), fine.shape)
    picture = Text()
    for upper in range(0, fine.shape[0], 2):
        for column in range(fine.shape[1]):
            top = _color(float(fine[upper, column]), bool(on[upper, column]))
            under = _color(float(fine[upper + 1, column]), bool(on[upper + 1, column]))
            picture.append(UPPER_HALF, style=f"{_rgb(top)} on {_rgb(under)}")
        picture.append("\n" if upper < fine.shape[0] - 2 else "")
    return picture


@contextmanager
def viewing(quiet: bool = False) -> Iterator[View]:
    """A view on stderr, where that is a terminal."""
    console = Console(stderr=True, highlight=False, markup=False)
    if quiet or not console.is_terminal:
        yield View(console=console)
        return
    with Live(Text("starting"), console=console, auto_refresh=False, transient=True) as live:
        yield View(live, console)


def _along(foot: Floats, direction: Floats, size: Floats, shape: tuple[int, int]) -> np.ndarray:
    """(rows, columns) which cells a line runs through, row 0 at the top."""
    on = np.zeros(shape, dtype=bool)
    reach = float(np.hypot(*size))
    points = foot + np.linspace(-reach, reach, 8 * max(shape))[:, None] * direction
    place = np.floor((points / size + 0.5) * np.array([shape[1], shape[0]])).astype(int)
    inside = ((place >= 0) & (place < [shape[1], shape[0]])).all(axis=1)
    on[shape[0] - 1 - place[inside, 1], place[inside, 0]] = True
    return on


def _color(share: float, line: bool) -> Color:
    return LINES[0] if line else INK if share < 0.0 else heat(share)


def _rgb(color: Color) -> str:
    return f"rgb({color[0]},{color[1]},{color[2]})"
