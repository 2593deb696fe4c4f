"""What a run's report shows, as plain arrays: the page is written from this and nothing else."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from primitives.arrays import Floats, Ints


@dataclass(frozen=True)
class ReportMesh:
    """Triangles to draw; `face` says which face of the boundary each belongs to."""

    vertices: Floats  # (v, 3) [mm] world frame
    triangles: Ints  # (t, 3)
    face: Ints  # (t,) id of a face in the summary; -1 where unknown


@dataclass(frozen=True)
class Deviation:
    """A model's surface in small triangles, and what their corners are off by."""

    mesh: ReportMesh
    distance: Floats  # (v,) [mm] positive where the model reaches out of the truth
    scale: float  # [mm] at which the color is full


@dataclass(frozen=True)
class ReportFrames:
    """What one array read, frame by frame."""

    times: Floats  # (m,) [s]
    poses: Floats  # (m, 4, 4) world_from_sensor
    counts: Floats  # (m, rows, columns) raw or corrected, any unit
    forces: Floats  # (m,) [N] along the sensor's z
    touch: Ints  # (m,) which touch, -1 between touches
    lines: Sequence[Floats] = ()  # per frame (k, 2): angle [rad], offset [mm] from the pad's center; or empty


@dataclass(frozen=True)
class SkinPicture:
    """A flat face as the images of a pad that lay on it show it, side by side."""

    face: int | None  # id in the summary, where it is there
    share: Floats  # (n, m) of the face under the skin, along x and y: 1 there, 0 not, nan where nobody looked
    step: float  # [mm]


@dataclass(frozen=True)
class RunReport:
    """Everything the page shows."""

    summary: Mapping[str, object]  # as in summary.json
    settings: Mapping[str, object]  # as in config.toml
    model: ReportMesh | None
    contacts: Floats  # (n, 3) [mm]
    contact_face: Ints  # (n,) id of a face in the summary; -1 where none
    frames: ReportFrames
    pad_size: tuple[float, float]  # (x, y) [mm] sensing area
    housing_size: tuple[float, float, float]  # (x, y, depth behind the skin) [mm]
    truth: ReportMesh | None = None
    off: Deviation | None = None  # of the model from the truth
    traces: Sequence[Floats] = field(default_factory=tuple)  # each (n, 3) [mm]
    pictures: Sequence[SkinPicture] = ()

    def __post_init__(self) -> None:
        frames = self.frames
        lengths = {len(frames.times), len(frames.poses), len(frames.counts), len(frames.forces)}
        if len(lengths) != 1 or (len(frames.lines) and len(frames.lines) not in lengths):
            raise ValueError("a report's frames need one time, pose, image and force each")
        if len(self.contacts) != len(self.contact_face):
            raise ValueError("a report's contacts need one face each")


EMPTY_FRAMES = ReportFrames(
    np.empty(0), np.empty((0, 4, 4)), np.empty((0, 1, 1)), np.empty(0), np.empty(0, dtype=np.int64)
)
