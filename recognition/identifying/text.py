"""Identifying as a terminal shows it: a line for each touch with the likeliest three as bars, and the answer."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.text import Text

from recognition.identifying.answer import reason_in_words, top
from recognition.identifying.identify import Identifier, Step
from recognition.report.ended import ended_words
from recognition.running.progress import Progress

_BAR = 14  # characters of a sure name
_FELT = 34
_NAME = 18


class TouchView:
    """Says each touch on stderr, where somebody looks."""

    def __init__(self, quiet: bool = False) -> None:
        self.folder: Path | None = None
        self._console = Console(stderr=True, highlight=False, markup=False, soft_wrap=True)
        self._quiet = quiet or not self._console.is_terminal

    def say(self, text: str) -> None:
        """A line that stays."""
        self._console.print(f"palpate: {text}")

    def told(self, progress: Progress) -> None:
        """Remember where the run is written."""
        self.folder = progress.folder or self.folder

    def touched(self, step: Step, identifier: Identifier) -> None:
        """One touch, and what is believed after it."""
        if not self._quiet:
            self._console.print(touch_line(step))


def touch_line(step: Step) -> Text:
    """What was felt, and the top three with bars."""
    line = Text(f"{step.touch.touch:3d}  ", style="dim")
    line.append(f"{step.touch.note[:_FELT]:<{_FELT}} ", style="default" if step.touch.met else "dim")
    for name, share in [] if step.belief is None else top(step.belief.probabilities):
        full = round(_BAR * share)
        line.append(f" {name[:_NAME]:>{_NAME}} ", style="bold" if share > 0.5 else "default")
        line.append("█" * full, style="green" if share > 0.5 else "yellow")
        line.append("·" * (_BAR - full), style="dim")
        line.append(f" {share:4.0%}")
    return line


def summary_text(summary: Mapping[str, Any], folder: Path | None = None) -> str:
    """The answer, what it cost, why not the runner-up, and how true it is."""
    s = summary
    touches = "1 touch" if s["touches"] == 1 else f"{s['touches']} touches"
    lines = [
        f"{s['part']}: {reason_in_words(s)}",
        f"{touches}, {s['travel_mm']:.0f} mm of travel in {s['device_seconds']:.1f} s on the device, "
        f"{s['wall_seconds']:.1f} s here; ended: {ended_words(s['ended'])}",
    ]
    pose = next((c for c in s["candidates"] if c["pose"] is not None and c["name"] == s["decision"]), None)
    if pose is not None:
        at = ", ".join(f"{x:.2f}" for x in pose["pose"]["translation_mm"])
        sigma = pose["pose_sigma"]
        lines.append(
            f"at {at} mm, within {sigma['translation_mm']:.2g} mm and {sigma['rotation_deg']:.2g} degrees "
            f"(1 sigma), symmetry {pose['symmetry']}"
        )
    lines += _why(s)
    truth = s.get("truth")
    if truth and s["met"]:
        verdict = "right" if truth["correct"] else f"wrong, it is {truth['name']}"
        if truth["translation_error_mm"] is not None:
            verdict += (
                f"; {truth['translation_error_mm']:.2g} mm and {truth['rotation_error_deg']:.2g} degrees off"
            )
        lines.append(f"against the truth: {verdict}")
    lines += [f"warning: {warning}" for warning in s.get("warnings") or []]
    report = (s.get("files") or {}).get("report")
    if report:
        lines += ["", f"report: {folder / report if folder else report}"]
    return "\n".join(lines)


def _why(s: Mapping[str, Any]) -> list[str]:
    why = s.get("why") or {}
    told = []
    contacts = why.get("separating_contacts") or []
    if why.get("runner_up") and contacts:
        numbers = ", ".join(map(str, contacts))
        told.append(f"not {why['runner_up']}: contacts {numbers} of contacts.csv speak against it")
    if why.get("separating_touch"):
        told.append(f"a touch that would tell more: {why['separating_touch']['bits']:.2f} bits expected")
    return told
