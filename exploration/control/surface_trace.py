"""From what each tick of a stroke felt to where the surface ran under it.

Every tick gives one point of the surface and its normal, with the frame's noise and the pose's.  Along the travel
s each coordinate is smoothed by a cubic spline as stiff as generalized cross-validation asks for (scipy's
`make_smoothing_spline`), so that white errors of the stage and of the frames average out over as long a piece of
the stroke as bends no more than they can hide.  Normals are smoothed in the same way and made unit again.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import make_smoothing_spline

from exploration.control.smoothing_spline import in_order, travel_along
from exploration.control.surface_reading import SurfaceReading
from primitives.arrays import Floats, frozen

LEAST = 12  # ticks of a trace
KNOTS = 160  # readings that a spline is fitted to; more are averaged in groups
SPACING = 1.0  # [mm] between the points of a trace
SUREST = 0.05  # [mm] of depth, beyond which a tick is left out


@dataclass(frozen=True)
class SurfaceTrace:
    """Where a stroke ran on the surface; false where too little was felt."""

    points: Floats  # (n, 3) [mm], in the order of travel
    normals: Floats  # (n, 3) outward
    travel: Floats  # (n,) [mm]
    sigma: Floats  # (n,) [mm] along the normal, but for errors that stay the same over a contact

    def __bool__(self) -> bool:
        return len(self.points) > 0


NO_TRACE = SurfaceTrace(*(frozen(np.empty(shape)) for shape in ((0, 3), (0, 3), 0, 0)))


def smoothed_surface(ticks: list[SurfaceReading], heading: Floats) -> SurfaceTrace:
    """The trace through the ticks of a stroke along a (2,) heading of the pad."""
    ticks = [tick for tick in ticks if tick.depth_sigma < SUREST]
    if len(ticks) < LEAST:
        return NO_TRACE
    points = np.array([tick.point for tick in ticks])
    normals = np.array([tick.normal for tick in ticks])
    travel = travel_of(ticks, heading)
    s, through, facing = in_order(travel, KNOTS, points, normals)
    if len(s) < LEAST:
        return NO_TRACE
    at = np.linspace(s[0], s[-1], max(2, int(np.ceil((s[-1] - s[0]) / SPACING)) + 1))
    runs = [make_smoothing_spline(s, column) for column in through.T]
    turns = [make_smoothing_spline(s, column) for column in facing.T]
    drawn = np.stack([run(at) for run in runs], axis=1)
    facing_there = np.stack([turn(at) for turn in turns], axis=1)
    facing_there /= np.linalg.norm(facing_there, axis=1, keepdims=True)
    off = np.sum((through - np.stack([run(s) for run in runs], axis=1)) * facing, axis=1)
    per_point = max(1.0, len(s) * SPACING / max(s[-1] - s[0], SPACING))
    sigma = np.full(len(at), float(off.std()) / np.sqrt(per_point))
    return SurfaceTrace(frozen(drawn), frozen(facing_there), frozen(at), frozen(sigma))


def travel_of(ticks: list[SurfaceReading], heading: Floats) -> Floats:
    """(n,) [mm] along a stroke: steps along the pad's heading on the surface, which noise does not shorten."""
    points, normals = np.array([t.point for t in ticks]), np.array([t.normal for t in ticks])
    along = np.array([t.world_from_sensor[:3, :2] @ heading for t in ticks])
    along -= np.sum(along * normals, axis=1, keepdims=True) * normals
    return travel_along(points, along)
