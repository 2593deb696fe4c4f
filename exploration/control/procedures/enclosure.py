"""Enclosure: a part smaller than the pad, or its end, held in one frame by its outline (Klatzky and Lederman).

The rubber moves pressure about and loses none, so a flat end pressed d deep has area = (sum of depth) A / d,
however it is blurred, where d is the depth that the outline's fit gives its plateau; centroid and principal axes
are those of the pressure.  The second moments of a bar of length L are L^2 / 12, with the blur's variance on top,
which is known and taken off (our derivation); a rim that is one circle is that circle.  Arcs and lines come from
the outline that explains the frame.

Property class: structural (global shape, volume).
"""

from dataclasses import dataclass
from math import pi

import numpy as np

from exploration.control.dwell import dwell
from exploration.control.feel import feel
from exploration.control.procedures.hardness import NotPressed
from exploration.devices.guard import Guard, Observation
from exploration.sensing.lines.arc import Arc
from exploration.sensing.lines.line import Line
from exploration.sensing.lines.outline import find_outline
from exploration.sensing.response import response_of
from primitives.arrays import Floats, frozen

SERVES = "structural: global shape, volume"


@dataclass(frozen=True)
class EnclosureConfig:
    """How one looks."""

    frames: int = 24  # averaged
    whole: float = 5.5  # [rad] of a circle, from which an arc is a whole rim
    sides: int = 4  # lines that are looked for
    sigmas: float = 4.0  # of a taxel's noise in the mean frame, that is contact


@dataclass(frozen=True)
class Enclosure:
    """The outline of what is under the pad."""

    enclosed: bool  # whether contact ends inside the pad all round
    area: float  # [mm^2]
    extent: tuple[float, float]  # [mm] along its principal axes, longer first
    center: Floats  # (3,) [mm] in the world
    axis: Floats  # (3,) unit direction of the longer extent
    round: bool  # whether one circle is the whole outline
    lines: tuple[Line, ...]
    arcs: tuple[Arc, ...]


def enclosure(guard: Guard, config: EnclosureConfig | None = None) -> Enclosure | NotPressed:
    """From a flush contact; the pad stands still."""
    config = config or EnclosureConfig()
    seen = dwell(guard, config.frames)
    felt = feel(seen.image)
    if not felt:
        return NotPressed("no contact to enclose; approach and settle first")
    outline = find_outline(seen.image, config.sides)
    rims = [arc for arc in outline.arcs if arc.material_inside and arc.span > config.whole]
    plateaus = [rim.plateau for rim in rims]
    plateaus += [line.plateau for line in outline.lines]
    plateaus = plateaus or [float(seen.image.depth[felt.inner].mean())]
    return _measured(seen, float(np.median(plateaus)), rims, outline.lines, outline.arcs, config)


def _measured(
    seen: Observation,
    plateau: float,
    rims: list[Arc],
    lines: tuple[Line, ...],
    arcs: tuple[Arc, ...],
    config: EnclosureConfig,
) -> Enclosure:
    image = seen.image
    live = np.isfinite(image.sigma)
    depth = np.where(live, image.depth, 0.0)
    border = np.concatenate([depth[0], depth[-1], depth[:, 0], depth[:, -1]])
    sigma = float(np.median(image.sigma[live]))
    enclosed = bool(border.max() < max(config.sigmas * sigma, 0.1 * plateau))
    cell = image.array.pitch[0] * image.array.pitch[1]
    grid = np.stack(np.broadcast_arrays(image.array.x[None], image.array.y[:, None]), axis=-1)
    weight = depth / depth.sum()
    middle = np.einsum("rc,rcx->x", weight, grid)
    moments = np.einsum("rc,rcx,rcy->xy", weight, grid - middle, grid - middle)
    moments -= np.diag(response_of(image).variance)
    size, axes = np.linalg.eigh(moments)
    whole = bool(rims) and len(lines) == 0 and len(arcs) == 1
    if whole:
        extent = (2.0 * rims[0].radius, 2.0 * rims[0].radius)
        middle, area = rims[0].center, pi * rims[0].radius ** 2
    else:
        long, short = np.sqrt(12.0 * np.maximum(size[::-1], 0.0)).tolist()
        extent, area = (long, short), float(depth.sum()) * cell / plateau
    place = seen.world_from_sensor
    center = place[:3, :3] @ np.array([*middle, -plateau]) + place[:3, 3]
    axis = place[:3, :2] @ axes[:, 1]
    return Enclosure(enclosed, area, extent, frozen(center), frozen(axis), whole, lines, arcs)
