"""Rows of one straight edge: every method on the same frames, one after another on each."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from perception.bound import ZERO, fisher
from perception.noise import Noise, observe
from perception.presses import Maker
from perception.scene import Scene
from perception.score import Tally, is_far, line_error, row
from perception.told_apart import findable
from perception.told_kind import FOUND, TOLD, TRIED, is_missed, said, told_lines

from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.line import Line
from exploration.sensing.lines.region import Terms
from primitives.arrays import Floats

Finder = Callable[[TactileImage], tuple[Line, ...]]
OURS = "palpate"
OTHERS_SEE = 10  # every tenth frame: they err by the thousand
WITHIN = 5.0  # times the bound
WEIGHED, FEWEST = 10, 40  # of how many frames one is, of at least so many, on which what can be found is told
RARELY = 4  # the same where hardly a line cannot


@dataclass(frozen=True)
class Asked:
    """What is asked of ours; None for nothing."""

    ratio: float | None = None
    bias: float | None = None  # [taxel]
    failures: float | None = None  # [%]
    findable: bool = False  # no more failures than the best of detectors has
    within: float | None = None  # [%] of lines within 5 times the bound


def drawn(maker: Maker, noise: Noise, frames: int, seed: int) -> list[tuple[Scene, TactileImage]]:
    """So many frames of a kind, the same for whoever asks."""
    rng = np.random.default_rng(seed)
    out = []
    for _ in range(frames):
        scene = maker(rng)
        out.append((scene, observe(scene, noise, rng)))
    return out


def tallies(
    methods: dict[str, Finder],
    pressed: list[tuple[Scene, TactileImage]],
    noise: Noise,
    terms: Terms | None = None,
) -> dict[str, Tally]:
    """The errors and times of every method, and of who is told that lines are joined by `terms`."""
    pitch = pressed[0][0].spec.array.pitch[0]
    several = len(pressed[0][0].found) > 1
    limits = [TOLD] * bool(terms) + [TRIED if several else FOUND] * bool(terms)
    out = {name: Tally(name, pitch) for name in (*limits, *methods)}
    for find in methods.values():
        find(pressed[0][1])
    for scene, image in pressed:
        truth = scene.found
        known = fisher(scene, noise)
        least, told = known.variances(), known.variances(ZERO)
        if terms:
            fit = told_lines(scene, image, terms)
            out[TOLD].add(said(fit), truth, least, told, np.nan)
        if terms and several:
            lines = said(fit) if is_missed(fit, image) else methods[OURS](image)
            out[TRIED].add(lines, truth, least, told, np.nan)
        for name, find in methods.items():
            began = time.perf_counter()
            lines = find(image)
            out[name].add(lines, truth, least, told, time.perf_counter() - began)
            if name == OURS and terms and not several and _found(lines, truth, pitch):
                out[FOUND].add(said(fit), truth, least, told, np.nan)
    return out


def _found(lines: tuple[Line, ...], truth: Floats, pitch: float) -> bool:
    return bool(lines) and not is_far(line_error((lines[0].angle, lines[0].offset), truth[0]), pitch)


def edge_rows(
    name: str,
    methods: dict[str, Finder],
    maker: Maker,
    noise: Noise,
    frames: int,
    asked: Asked,
    terms: Terms | None = None,
    untold: str | None = None,
) -> list[dict[str, Any]]:
    """Accuracy over the bound, bias, failures and time of each method on one kind of frame.

    Where a number of the scene is told to ours, `untold` is its name: the bound of who is not told it stands by.
    """
    pressed = drawn(maker, noise, frames, sum(map(ord, name)))
    found = tallies(methods, pressed, noise, terms)
    pitch = pressed[0][0].spec.array.pitch[0]
    some = next(iter(found.values()))
    rows = []
    if some.least:
        rms = np.sqrt(np.mean(some.least, axis=0))
        rows.append(row("bound", f"{name}: angle RMS", np.degrees(rms[0]), "deg"))
        rows.append(row("bound", f"{name}: offset RMS", rms[1] / pitch, "taxel"))
    if untold:
        blind = [
            fisher(scene, noise, (*scene.unknown, untold)).variances()[0] for scene, _ in pressed[::WEIGHED]
        ]
        rms = np.sqrt(np.mean(blind, axis=0))
        rows.append(row("bound", f"{name}: angle RMS, {untold} not told", np.degrees(rms[0]), "deg"))
        rows.append(row("bound", f"{name}: offset RMS, {untold} not told", rms[1] / pitch, "taxel"))
    if asked.findable or asked.failures is not None:
        least = 100.0 - _findable(pressed, noise, WEIGHED if asked.findable else RARELY)
        asked = replace(asked, failures=least if asked.findable else asked.failures)
        rows.append(row("bound", f"{name}: failures", least, "%"))
    for method, tally in found.items():
        ours = asked if method == OURS else Asked()
        angle, offset = tally.pooled()
        rows.append(row(method, f"{name}: angle RMS over the bound", angle, "1", ours.ratio))
        rows.append(row(method, f"{name}: offset RMS over the bound", offset, "1", ours.ratio))
        if method == OURS:
            angle, offset = tally.pooled(told=True)
            rows.append(row(method, f"{name}: angle RMS over the bound, zero known", angle, "1"))
            rows.append(row(method, f"{name}: offset RMS over the bound, zero known", offset, "1"))
        if tally.errors:
            bias = np.mean(tally.errors, axis=0)
            rows.append(row(method, f"{name}: bias into the material", bias[1] / pitch, "taxel", ours.bias))
        failed = 100 * tally.missed / tally.total
        rows.append(row(method, f"{name}: failures", failed, "%", ours.failures))
        if method not in (TOLD, FOUND):
            rows.append(row(method, f"{name}: median time", tally.median_time(), "us"))
    return rows


def many_rows(
    name: str,
    methods: dict[str, Finder],
    maker: Maker,
    terms: Terms,
    noise: Noise,
    frames: int,
    asked: Asked,
) -> list[dict[str, Any]]:
    """The same for frames of several lines, each error over its own frame's joint bound."""
    pressed = drawn(maker, noise, frames, sum(map(ord, name)))
    most = _findable(pressed, noise, times=WITHIN)
    rows = [row("bound", f"{name}: lines within 5 x the bound", most, "%")]
    for method, tally in tallies(methods, pressed, noise, terms).items():
        ours = asked if method == OURS else Asked()
        angle, offset = tally.by_frame()
        rows += [
            row(method, f"{name}: angle RMS over the joint bound", angle, "1", ours.ratio),
            row(method, f"{name}: offset RMS over the joint bound", offset, "1", ours.ratio),
            row(method, f"{name}: lines within 5 x the bound", tally.within(WITHIN), "%", ours.within),
            row(
                method,
                f"{name}: the same of lines whose bound is below 3 deg, 0.3 taxel",
                tally.held_within(),
                "%",
            ),
            row(method, f"{name}: lines not found", 100 * tally.missed / tally.total, "%"),
            row(method, f"{name}: surplus lines", 100 * tally.surplus / tally.frames, "per 100 frames"),
        ]
        if method not in (TOLD, TRIED):
            rows.append(row(method, f"{name}: median time", tally.median_time(), "us"))
    return rows


def _findable(
    pressed: list[tuple[Scene, TactileImage]], noise: Noise, weighed: int = WEIGHED, times: float = np.inf
) -> float:
    """[%] of their lines that the best of detectors finds, within so many times the bound."""
    some = pressed[: max(FEWEST, len(pressed) // weighed)]
    return 100.0 * findable([scene for scene, _ in some], noise, times)


def false_rows(
    methods: dict[str, Finder],
    makers: dict[str, Maker],
    noise: Noise,
    frames: int,
    limit: float | None = 3.0,
) -> list[dict[str, Any]]:
    """Frames with a line where there is none, in 10,000; other methods see one frame in `OTHERS_SEE`."""
    rows = []
    for kind, maker in makers.items():
        rng = np.random.default_rng(sum(map(ord, kind)))
        seen, false = dict.fromkeys(methods, 0), dict.fromkeys(methods, 0)
        for k in range(frames):
            image = observe(maker(rng), noise, rng)
            for name, find in methods.items():
                if name.startswith(OURS) or k % OTHERS_SEE == 0:
                    seen[name] += 1
                    false[name] += bool(find(image))
        for name in methods:
            share = 1e4 * false[name] / seen[name]
            asked = limit if name.startswith(OURS) else None
            rows.append(row(name, f"false lines: {kind}", share, "in 10,000", asked))
    return rows
