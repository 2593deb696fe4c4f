"""What a page shows of a recording: traces, and a bounded choice of frames, those in contact more densely."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from exploration.planning.known.face_pictures import FacePicture
from exploration.recordings.mcap import RecordedEvent, RecordedFrame, read
from exploration.sensing.calibration import Calibration, correct
from exploration.sensing.lines.hough import sure_lines
from exploration.sensing.spec import SensorSpec, load_sensor, sensor_from_toml, sensor_names
from primitives.arrays import Floats
from primitives.errors import PalpateError
from primitives.toml_text import toml_lines
from recognition.report.one_grid import laid
from recognition.report.run_report import EMPTY_FRAMES, ReportFrames
from recognition.running.logbook import APPROACH
from recognition.running.picture_log import PICTURE, picture

_CONTACT, _FREE = 400, 150  # frames that are shown
_SHARE = 0.02  # of the largest force, above which a frame is in contact


@dataclass(frozen=True)
class Recorded:
    """Frames on the grid of the first array, and where edges ran; sizes are zero where it is not known."""

    frames: ReportFrames = EMPTY_FRAMES
    traces: Sequence[Floats] = ()  # each (n, 3) [mm]
    pad: tuple[float, float] = (0.0, 0.0)
    housing: tuple[float, float, float] = (0.0, 0.0, 0.0)
    pictures: Sequence[FacePicture] = ()  # of flat faces


def recorded(path: Path, specs: Sequence[SensorSpec] = ()) -> Recorded:
    """What to show of an episode; `specs` describe its arrays where they are not built-in ones.

    Of several arrays those are shown of which more is known than the name; of one that is not known, the frames.
    """
    first, forces, begun, traces = "", list[float](), list[int](), list[Floats]()
    pictures = list[FacePicture]()
    touches, known = 0, {spec.name: spec for spec in specs}
    for item in read(path):
        if isinstance(item, RecordedEvent):
            traces += _trace(item)
            seen = picture(item.detail) if item.kind == PICTURE else None
            pictures += [] if seen is None else [seen]
            touches = _begun(item, touches)
            continue
        first = first or item.sensor
        if item.sensor not in known and item.sensor in sensor_names():
            known[item.sensor] = load_sensor(item.sensor)
        if item.sensor == first or (first in known and item.sensor in known):
            forces.append(-float(item.wrench[2]))
            begun.append(touches)
    spec = known.get(first)
    pad, housing = ((0.0, 0.0), (0.0, 0.0, 0.0)) if spec is None else (spec.array.size, spec.housing.size)
    if not forces:
        return Recorded(EMPTY_FRAMES, traces, pad, housing, pictures)
    force = np.array(forces)
    pressed = force > _SHARE * max(float(force.max()), 1e-9)
    touch = np.where(pressed, np.maximum(begun, 1) - 1, -1)
    wanted = {*_spread(np.flatnonzero(pressed), _CONTACT), *_spread(np.flatnonzero(~pressed), _FREE)}
    chosen = sorted(wanted)
    kept = _kept(path, first, known, wanted)
    frames = ReportFrames(
        times=np.array([item.frame.time for item in kept]),
        poses=np.stack([item.world_from_sensor for item in kept]),
        counts=np.stack([_on_first(item, first, known) for item in kept]),
        forces=force[chosen],
        touch=touch[chosen],
        lines=_lines(kept, pressed[chosen].tolist(), known),
    )
    return Recorded(frames, traces, pad, housing, pictures)


def _begun(event: RecordedEvent, before: int) -> int:
    """How many touches had begun after an event; a recording of another maker tells of none."""
    number = event.detail.get("number") if event.kind == APPROACH else None
    return number if isinstance(number, int) else before


def resolved_specs(resolved: Mapping[str, Any]) -> tuple[SensorSpec, ...]:
    """The arrays as `config.toml` describes them; none where it does not."""
    try:
        return tuple(
            map(_spec, resolved["sensors"].values() if "sensors" in resolved else [resolved["sensor"]])
        )
    except (KeyError, TypeError, ValueError, AttributeError, PalpateError):
        return ()


def _spec(described: Mapping[str, Any]) -> SensorSpec:
    told = dict(described)
    array = dict(told.pop("array"))
    name = str(array.pop("name"))
    return sensor_from_toml("\n".join(toml_lines({"name": name, **told, "array": array})), name)


def _on_first(item: RecordedFrame, first: str, known: Mapping[str, SensorSpec]) -> Floats:
    if item.sensor == first:
        return item.frame.counts
    return laid(item.frame.counts, known[item.sensor], known[first])


def _kept(path: Path, first: str, known: Mapping[str, SensorSpec], wanted: set[int]) -> list[RecordedFrame]:
    kept, number = list[RecordedFrame](), 0
    for item in read(path):
        if not isinstance(item, RecordedFrame):
            continue
        if item.sensor == first or (first in known and item.sensor in known):
            if number in wanted:
                kept.append(item)
            number += 1
    return kept


def _lines(
    kept: Sequence[RecordedFrame], pressed: Sequence[bool], known: Mapping[str, SensorSpec]
) -> list[Floats]:
    """Angle and offset of each line in each frame that touches; none where an array is not known."""
    if any(k.sensor not in known or k.frame.counts.shape != known[k.sensor].array.shape for k in kept):
        return []
    calibrations = {name: Calibration.nominal(spec) for name, spec in known.items()}
    return [
        np.array(
            [
                (line.angle, line.offset)
                for line in sure_lines(
                    correct(item.frame, calibrations[item.sensor], known[item.sensor].array)
                )
            ]
            if touches
            else []
        ).reshape(-1, 2)
        for item, touches in zip(kept, pressed, strict=True)
    ]


def _trace(event: RecordedEvent) -> list[Floats]:
    if event.kind != "trace":
        return []
    points = np.array(event.detail.get("points_mm", []), dtype=float).reshape(-1, 3)
    return [points] if len(points) > 1 else []


def _spread(places: np.ndarray, most: int) -> list[int]:
    picked = np.unique(np.linspace(0, len(places) - 1, min(most, len(places))).astype(np.int64))
    return [int(place) for place in places[picked]]
