"""A recording felt anew: its frames perceived, the contacts that they yield, and the space that the pad swept.

Frames of a standing pad repeat each other, so one is taken for each step of the pad while it touches.  A recording
that a kill cut short gives what is whole of it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from exploration.recordings.episode import read_episode
from exploration.recordings.intake import opened
from exploration.recordings.mcap import RecordedFrame, events, read
from exploration.recordings.recording import Pad, PadFrame
from exploration.sensing.calibration import correct
from exploration.sensing.contacts import contacts_of
from primitives import pose as se3
from primitives.arrays import Floats, frozen
from primitives.errors import PalpateError
from primitives.evidence import Contacts, FreeSpace
from recognition.frames.felt import Feeler, unreadable
from recognition.running.logbook import APPROACH, STROKE, force_sigma
from recognition.sources.source import Felt


@dataclass(frozen=True)
class ReplayOptions:
    """Which frames are looked at."""

    step: float = 2.0  # [mm] that the pad moves between two frames that are perceived
    turn: float = 0.03  # [rad] or turns
    settled: int = 3  # frames in contact before the first that is
    most: int = 800  # frames perceived; more are thinned
    sigmas: float = 6.0  # of force out of its noise, from which a frame is in contact
    sweep_step: float = 6.0  # [mm] between swept boxes
    spare: float = 1.0  # [mm] by which swept boxes are smaller than pad and housing


@dataclass(frozen=True)
class Replayed:
    """Contacts and cost of an episode."""

    contacts: Contacts
    felt: Felt
    warnings: tuple[str, ...]


def felt_contacts(
    path: Path, known: Contacts | None = None, options: ReplayOptions | None = None
) -> Replayed:
    """The contacts of every step in touch, in the world frame; where they are `known`, only what they cost."""
    options = options or ReplayOptions()
    with opened(path):
        pass
    if not any(isinstance(item, RecordedFrame) for item in read(path)):
        return Replayed(Contacts.of(np.empty((0, 3))), Felt(), ("the recording ends before its first frame",))
    recording = read_episode(path)
    if not recording.posed:
        raise PalpateError(f"{path} carries no poses; give the episode.mcap of a run")
    feeler = Feeler.of(recording)
    chosen, felt = _chosen(feeler, options)
    felt = _counted(path, felt)
    if known is not None:
        return Replayed(known, felt, recording.warnings)
    stride = -(-len(chosen) // options.most) if chosen else 1
    tables: list[Contacts] = []
    for item, touch in chosen[::stride]:
        seen = feeler.perceived(item)
        assert item.world_from_sensor is not None
        rows = contacts_of(seen.touch, item.world_from_sensor, touch, len(tables), item.pad)
        good = np.isfinite(rows.points).all(axis=1) & np.isfinite(rows.sigma) & (rows.sigma > 0)
        if good.any():
            tables.append(rows.select(good))
    return Replayed(Contacts.concatenate(tables), felt, recording.warnings)


def _counted(path: Path, felt: Felt) -> Felt:
    """With touches and strokes as a recording says that they began, where it does: contact breaks within one."""
    begun: dict[str, int] = {}
    for event in events(path):
        number = event.detail.get("number")
        if event.kind in (APPROACH, STROKE) and isinstance(number, int):
            begun[event.kind] = number
    if APPROACH not in begun:
        return felt
    return replace(felt, touches=begun[APPROACH], strokes=begun.get(STROKE, 0))


def _chosen(feeler: Feeler, options: ReplayOptions) -> tuple[list[tuple[PadFrame, int]], Felt]:
    """Frames in contact, a step apart, each with its touch; and what the whole cost."""
    chosen: list[tuple[PadFrame, int]] = []
    touch, touching, since, pad = -1, False, 0, 0
    count, travel, first, last = 0, 0.0, 0.0, 0.0
    here: Floats | None = None
    kept: Floats | None = None
    for item in feeler.recording.frames():
        pose = item.world_from_sensor
        if pose is None:
            continue
        travel += 0.0 if here is None or item.pad != pad else float(np.linalg.norm(pose[:3, 3] - here[:3, 3]))
        here, last = pose, item.frame.time
        first = item.frame.time if count == 0 else first
        count += 1
        touching, pad = touching and item.pad == pad, item.pad
        if not _presses(feeler, item, options):
            touching = False
            continue
        if not touching:
            touch, touching, since, kept = touch + 1, True, 0, None
        since += 1
        if since >= options.settled and (kept is None or _moved(kept, pose, options)):
            chosen.append((item, touch))
            kept = pose
    return chosen, Felt(touch + 1, touch + 1, count, travel, last - first, feeler.recording.sensor)


def _presses(feeler: Feeler, item: PadFrame, options: ReplayOptions) -> bool:
    pad, calibration = feeler.recording.pads[item.pad], feeler.calibrations[item.pad]
    if unreadable(item.frame.counts, pad, feeler.rests[item.pad]):
        return False
    image = correct(item.frame, calibration, pad.array)
    live = np.isfinite(image.sigma)
    area = pad.array.pitch[0] * pad.array.pitch[1]
    return bool(image.stiffness * area * image.depth[live].sum() > options.sigmas * force_sigma(image))


def _moved(a: Floats, b: Floats, options: ReplayOptions) -> bool:
    if float(np.linalg.norm(a[:3, 3] - b[:3, 3])) > options.step:
        return True
    return float(np.linalg.norm(a[:3, 2] - b[:3, 2])) > options.turn


def swept(path: Path, options: ReplayOptions | None = None) -> FreeSpace:
    """The boxes of housing, and of skin less what it was pressed in, at every step of the way."""
    options = options or ReplayOptions()
    recording = read_episode(path)
    boxes = list(_boxes(recording.pads, recording.frames(), options))
    poses = np.stack([pose for pose, _ in boxes]) if boxes else np.empty((0, 4, 4))
    halves = np.stack([half for _, half in boxes]) if boxes else np.empty((0, 3))
    return FreeSpace(frozen(poses), frozen(halves))


def _boxes(
    pads: tuple[Pad, ...], frames: Iterator[PadFrame], options: ReplayOptions
) -> Iterator[tuple[Floats, Floats]]:
    kept: dict[int, Floats] = {}
    for item in frames:
        pose, spec = item.world_from_sensor, pads[item.pad].spec
        before = kept.get(item.pad)
        if pose is None or spec is None:
            continue
        if before is not None and float(np.linalg.norm(pose[:3, 3] - before[:3, 3])) < options.sweep_step:
            continue
        kept[item.pad] = pose
        housing = spec.housing
        width, height = (side + 2 * spec.elastomer.margin for side in spec.array.size)
        room = (
            (width, height, -housing.proud, -options.spare - spec.elastomer.thickness),
            (
                housing.size[0],
                housing.size[1],
                -housing.proud - housing.size[2],
                -housing.proud - options.spare,
            ),
        )
        for x, y, low, high in room:
            half = np.array([x / 2 - options.spare, y / 2 - options.spare, (high - low) / 2])
            if (half > 0).all():
                yield pose @ se3.pose(translation=[0.0, 0.0, (low + high) / 2]), half
