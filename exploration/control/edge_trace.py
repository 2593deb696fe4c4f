"""From what each tick saw of an edge to where it ran.

Every tick yields one point of the edge, its direction and the face's normal, with the frame's noise and the
pose's.  Along the travel s each coordinate is smoothed by a cubic spline (`smoothing_spline`), as stiff as
cross-validation allows: of the splines through every other reading, the one that misses the readings between them
least.  A straight edge becomes a straight line of all its ticks, a bent one keeps its bends.

While tracking, the bend of an edge is filtered from what lies behind, and lags where it changes.  Afterwards it is
smoothed from both sides (Rauch, Tung and Striebel, for a random walk); every frame is fitted once more with it,
and over less of the edge where it changes: a change of c [1/mm] within a reach r moves the fit by up to c r^2 / 6.
"""

from dataclasses import dataclass, replace

import numpy as np

from exploration.control.smoothing_spline import Readings, Spline
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.follow_line import Expected, Followed, follow_line
from exploration.sensing.response import Response
from primitives.arrays import Floats, frozen
from primitives.evidence import EdgeTrace

LEAST = 8  # ticks of a trace
SPACING = 1.0  # [mm] between the points of a trace
KNOTS = 240  # readings that the spline is fitted to; more are averaged in groups
STIFFNESSES = (*np.geomspace(1e-2, 1e6, 9), np.inf)  # [mm^3] of the smoothing spline; a line at the end
STEP = 1e-3  # [mm] readings nearer than this are one
SLACK = 0.002  # share by which a stiffer spline may miss more
SHORT = 30.0  # [mm] an edge is straight unless its readings clearly say otherwise
BEND_SIGMA = 0.002  # [1/mm] least to which a smoothed bend is known
STRAIGHT = 1e-4  # [1/mm] the same, of an edge that is straight
MOVED = 0.03  # [mm] by which a changing bend may move a fit
NEAREST = 4.0  # [mm] of the edge, either way, that a fit needs


@dataclass(frozen=True)
class EdgeTick:
    """The edge as one tick saw it."""

    edge: Followed
    image: TactileImage  # as it was fitted
    world_from_sensor: Floats  # (4, 4)
    force: float  # [N]

    @property
    def point(self) -> Floats:
        """(3,) [mm] of the edge beside the pad's center."""
        local = np.array([*self.edge.foot, -self.edge.plateau])
        point: Floats = self.world_from_sensor[:3, :3] @ local + self.world_from_sensor[:3, 3]
        return point

    @property
    def tangent(self) -> Floats:
        """(3,) unit direction of travel."""
        tangent: Floats = self.world_from_sensor[:3, :2] @ self.edge.direction
        return tangent

    @property
    def inward(self) -> Floats:
        """(3,) unit direction in the face, into the material."""
        inward: Floats = self.world_from_sensor[:3, :2] @ self.edge.inward
        return inward

    @property
    def normal(self) -> Floats:
        """(3,) outward normal of the face."""
        tilt = self.world_from_sensor[:3, :3] @ np.array([-self.edge.slope[0], -self.edge.slope[1], -1.0])
        normal: Floats = tilt / np.linalg.norm(tilt)
        return normal


@dataclass(frozen=True)
class _Run:
    """The spline through a run of ticks."""

    travel: Floats  # (n,) [mm] of each tick
    spline: Spline  # (3) columns, [mm] over [mm]
    spread: float  # [mm] of the readings about it
    straight: bool  # whether nothing speaks for a bend


def smoothed(
    ticks: list[EdgeTick],
    closed: bool,
    touch: int,
    stroke: int,
    response: Response,
    reach: float,
    drift: float,
) -> EdgeTrace | None:
    """The trace through all ticks; None where they are too few.

    `reach` [mm] of the edge, either way, are fitted in a frame; its bend changes by `drift` [1/mm] within a mm.
    """
    ticks = _fitted_again(ticks, response, reach, drift)
    run = _drawn(ticks)
    if run is None:
        return None
    first, last = float(run.travel.min()), float(run.travel.max())
    at = np.linspace(first, last, max(2, int(np.ceil((last - first) / SPACING)) + 1))
    along = run.spline.at(at, 1)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    normals = np.array([tick.normal for tick in ticks])
    order = np.argsort(run.travel)
    turned = np.stack([np.interp(at, run.travel[order], column[order]) for column in normals.T], axis=1)
    turned -= np.sum(turned * along, axis=1, keepdims=True) * along
    turned /= np.linalg.norm(turned, axis=1, keepdims=True)
    per_point = max(1.0, len(ticks) * SPACING / max(last - first, SPACING))
    sigma = np.full(len(at), run.spread / np.sqrt(per_point))
    return EdgeTrace(
        frozen(run.spline.at(at)), frozen(along), frozen(turned), frozen(sigma), closed, touch, stroke
    )


def _drawn(ticks: list[EdgeTick]) -> _Run | None:
    """The spline through the ticks' points."""
    if len(ticks) < LEAST:
        return None
    points = np.array([tick.point for tick in ticks])
    sigma = np.sqrt([tick.edge.covariance[1, 1] for tick in ticks])
    travel = _travel(points, np.array([tick.tangent for tick in ticks]))
    order = np.argsort(travel, kind="stable")
    size = max(1, int(np.ceil(len(ticks) / KNOTS)))
    s, through, weight = (
        _grouped(v[order], size) for v in (travel, points, 1.0 / np.maximum(sigma, 0.01) ** 2)
    )
    apart = np.concatenate([[True], np.diff(s) > STEP])
    s, through, weight = s[apart], through[apart], weight[apart] / weight[apart].mean()
    if len(s) < LEAST:
        return None
    readings = Readings(s, through, weight)
    stiffness = _stiffness(readings)
    spline = readings.smoothed(stiffness)
    off = points - spline.at(travel)
    return _Run(travel, spline, float(off.std(axis=0).max()), stiffness >= STIFFNESSES[-1])


def _fitted_again(ticks: list[EdgeTick], response: Response, reach: float, drift: float) -> list[EdgeTick]:
    """Every frame's edge once more, its bend smoothed; ticks that no longer fit drop out."""
    if len(ticks) < LEAST:
        return ticks
    run = _drawn(ticks)
    travel, bends, sigmas = _bends(ticks, drift)
    if run is not None and run.straight:
        bends, sigmas = np.zeros_like(bends), np.zeros_like(sigmas)
    floor = STRAIGHT if run is not None and run.straight else BEND_SIGMA
    again = []
    for tick, s, bend, sigma in zip(ticks, travel, bends, sigmas, strict=True):
        edge = tick.edge
        within = bends[np.abs(travel - s) < reach]
        change = max(0.0, float(np.ptp(within)) - 2.0 * BEND_SIGMA)
        near = min(reach, max(NEAREST, np.sqrt(6.0 * MOVED / max(change, 1e-9))))
        near = min(near, 0.8 / max(abs(bend), 1e-6))
        expected = Expected(
            edge.angle, edge.offset, edge.side, bend, max(sigma, floor, change / 4.0), float(near)
        )
        fit = follow_line(tick.image, response, expected)
        if fit:
            again.append(replace(tick, edge=fit))
    return again


def _bends(ticks: list[EdgeTick], drift: float) -> tuple[Floats, Floats, Floats]:
    """Travel [mm], bend and its standard deviation [1/mm] at every tick, from the ticks before and behind."""
    points = np.array([tick.point for tick in ticks])
    travel = _travel(points, np.array([tick.tangent for tick in ticks]))
    steps = np.maximum(np.diff(travel), 0.0)
    bends = [tick.edge.bend for tick in ticks]
    variances = [float(tick.edge.covariance[5, 5]) for tick in ticks]
    for k in range(len(ticks) - 2, -1, -1):
        predicted = variances[k] + drift**2 * float(steps[k])
        gain = variances[k] / max(predicted, 1e-12)
        bends[k] += gain * (bends[k + 1] - bends[k])
        variances[k] += gain**2 * (variances[k + 1] - predicted)
    return travel, np.array(bends), np.sqrt(np.maximum(variances, 0.0))


def _stiffness(readings: Readings) -> float:
    """The stiffness that predicts readings which it has not seen."""
    s = readings.places
    if len(s) < 4 * LEAST:
        return float(STIFFNESSES[-1])
    missed = [readings.missed(float(stiffness)) for stiffness in STIFFNESSES]
    if s[-1] - s[0] < SHORT and missed[-1] <= (1.0 + 2.0 / np.sqrt(len(s))) * min(missed):
        return float(STIFFNESSES[-1])
    best = np.flatnonzero(np.array(missed) <= (1.0 + SLACK) * min(missed))
    return float(STIFFNESSES[int(best.max())])


def _travel(points: Floats, tangents: Floats) -> Floats:
    """(n,) [mm] along the edge: steps along the tangent, which the noise across it does not lengthen."""
    middle = tangents[1:] + tangents[:-1]
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    return np.concatenate([[0.0], np.cumsum(np.sum(np.diff(points, axis=0) * middle, axis=1))])


def _grouped(values: Floats, size: int) -> Floats:
    """Means of every `size` values in turn."""
    whole = len(values) // size * size
    means: Floats = values[:whole].reshape(-1, size, *values.shape[1:]).mean(axis=1)
    return means
