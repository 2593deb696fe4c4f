"""A trial of an edge detector on simulated frames, the same frames for every detector.

A pad is pressed on a scene at a random place, attitude about its normal, and slight lean; the frame runs through
the whole simulated array.  A line is found where one lies within 15 degrees and 1.5 taxels of it, at the point of
it that is nearest the pad's center; each line that is there is found once.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from math import atan2, cos, pi, sin
from typing import Any

import numpy as np

from exploration.devices.simulated import simulate
from exploration.sensing.baselines.table import baselines
from exploration.sensing.calibration import Calibration, correct
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.hough import find_lines
from exploration.sensing.lines.line import Line, normalized
from primitives.errors import PalpateError
from recognition.experiments.kinds.scenes import Press, pressed
from recognition.experiments.kinds.sensors import spec_of
from recognition.experiments.settings import Value, closest
from recognition.experiments.trial import Work

FAR_ANGLE = np.radians(15.0)
FAR_OFFSET = 1.5  # [taxels]
Finder = Callable[[TactileImage], tuple[Line, ...]]


def detectors() -> dict[str, Finder]:
    """Ours, and what is installed to compare it with."""
    return {"palpate": find_lines, **baselines()}


def carry(settings: Mapping[str, Value], work: Work) -> dict[str, Value]:
    """Find lines in so many frames."""
    s: Mapping[str, Any] = settings
    found = detectors()
    if s["detector"] not in found:
        raise PalpateError(f"no detector {s['detector']!r}{closest(s['detector'], found)}")
    find, spec = found[s["detector"]], spec_of(s, work)
    calibration = Calibration.nominal(spec)
    rng = np.random.default_rng([s["seed"], *s["scene"].encode()])
    errors, times, there, false = list[tuple[float, float]](), list[float](), 0, 0
    for number in range(s["count"]):
        press = pressed(s["scene"], spec, rng)
        _, (array,) = simulate(press.solid, [spec], rng, start_pose=press.world_from_sensor)
        image = correct(array.read(), calibration, spec.array)
        if number == 0:
            find(image)  # compiles what it must, apart from the clock
        began = time.perf_counter()
        lines = find(image)
        times.append(time.perf_counter() - began)
        matched = matches(press, lines, FAR_OFFSET * min(spec.array.pitch))
        errors += matched
        there += len(press.lines)
        false += len(lines) - len(matched)
    angle, offset = np.sqrt(np.mean(np.square(errors), axis=0)) if errors else (None, None)
    return {
        "lines": there,
        "found": len(errors),
        "found_share": len(errors) / there if there else None,
        "false_lines": false,
        "angle_rms_deg": None if angle is None else float(np.degrees(angle)),
        "offset_rms_mm": None if offset is None else float(offset),
        "frame_seconds": float(np.median(times)),
    }


def matches(press: Press, lines: tuple[Line, ...], far: float) -> list[tuple[float, float]]:
    """Errors of angle [rad] and offset [mm] of the lines that were found, nearest pairs first."""
    pairs = sorted(
        (abs(turn) / FAR_ANGLE + abs(shift) / far, i, j, turn, shift)
        for i, truth in enumerate(press.lines)
        for j, line in enumerate(lines)
        for turn, shift in [_error(line, truth)]
        if abs(turn) <= FAR_ANGLE and abs(shift) <= far
    )
    out, taken, used = list[tuple[float, float]](), set[int](), set[int]()
    for _, i, j, turn, shift in pairs:
        if i not in taken and j not in used:
            taken.add(i)
            used.add(j)
            out.append((turn, shift))
    return out


def _error(line: Line, truth: tuple[float, float]) -> tuple[float, float]:
    angle, offset, _ = normalized(*truth, 1)
    turn = (line.angle - angle + pi / 2) % pi - pi / 2
    foot = (-offset * sin(angle), offset * cos(angle))
    shift = line.offset - (-sin(line.angle) * foot[0] + cos(line.angle) * foot[1])
    return atan2(sin(turn), cos(turn)), shift
