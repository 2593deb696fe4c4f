"""The frames of a recording that a page shows: a bounded choice, evenly spread, those in contact more densely."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from exploration.recordings.mcap import RecordedEvent, RecordedFrame, read
from exploration.sensing.spec import load_sensor, sensor_names
from recognition.report.run_report import EMPTY_FRAMES, ReportFrames

_CONTACT, _FREE = 400, 150  # frames that are shown
_SHARE = 0.02  # of the largest force, above which a frame is in contact
Size = tuple[tuple[float, float], tuple[float, float, float]]


def recorded_frames(path: Path) -> tuple[ReportFrames, tuple[float, float], tuple[float, float, float]]:
    """Frames of the first array, and the sizes of its pad and housing; zero where it is not built in."""
    first, forces = "", list[float]()
    for item in read(path):
        if isinstance(item, RecordedEvent):
            continue
        first = first or item.sensor
        if item.sensor == first:
            forces.append(-float(item.wrench[2]))
    pad, housing = _sizes(first)
    if not forces:
        return EMPTY_FRAMES, pad, housing
    force = np.array(forces)
    pressed = force > _SHARE * max(float(force.max()), 1e-9)
    touch = np.where(pressed, np.cumsum(np.diff(pressed, prepend=False) & pressed) - 1, -1)
    wanted = {*_spread(np.flatnonzero(pressed), _CONTACT), *_spread(np.flatnonzero(~pressed), _FREE)}
    kept, number = list[RecordedFrame](), 0
    for item in read(path):
        if isinstance(item, RecordedFrame) and item.sensor == first:
            if number in wanted:
                kept.append(item)
            number += 1
    chosen = sorted(wanted)
    return (
        ReportFrames(
            times=np.array([item.frame.time for item in kept]),
            poses=np.stack([item.world_from_sensor for item in kept]),
            counts=np.stack([item.frame.counts for item in kept]),
            forces=force[chosen],
            touch=touch[chosen],
        ),
        pad,
        housing,
    )


def _spread(places: np.ndarray, most: int) -> list[int]:
    picked = np.unique(np.linspace(0, len(places) - 1, min(most, len(places))).astype(np.int64))
    return [int(place) for place in places[picked]]


def _sizes(sensor: str) -> Size:
    if sensor not in sensor_names():
        return (0.0, 0.0), (0.0, 0.0, 0.0)
    spec = load_sensor(sensor)
    return spec.array.size, spec.housing.size
