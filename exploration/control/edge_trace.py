"""From what each tick saw of an edge to where it ran.

Every tick yields one point of the edge, its direction and the face's normal, with the frame's noise and the
pose's.  Along the travel s each coordinate is smoothed by a cubic spline (`smoothing_spline`), as stiff as
cross-validation allows: of the splines through every other reading, the one that misses the readings between them
least.  A straight edge becomes a straight line of all its ticks, a bent one keeps its bends.

While tracking, the bend of an edge is filtered from what lies behind, and lags where it changes.  Afterwards it is
smoothed from both sides (Rauch, Tung and Striebel, for a random walk); every frame is fitted once more with it,
and over less of the edge where it changes: a change of c [1/mm] within a reach r moves the fit by up to c r^2 / 6.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numba
import numpy as np

from exploration.control.smoothing_spline import Readings, Spline, in_order, travel_along
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.follow_line import follow_lines
from exploration.sensing.lines.followed import Followed
from exploration.sensing.response import Response
from primitives.arrays import Bools, Floats, frozen
from primitives.evidence import EdgeTrace

LEAST = 8  # ticks of a trace
SPACING = 1.0  # [mm] between the points of a trace
KNOTS = 240  # readings that the spline is fitted to; more are averaged in groups
STIFFNESSES = (*np.geomspace(1e-2, 1e6, 9), np.inf)  # [mm^3] of the smoothing spline; a line at the end
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

    @cached_property
    def point(self) -> Floats:
        """(3,) [mm] of the edge beside the pad's center."""
        return self._placed[0]

    @property
    def tangent(self) -> Floats:
        """(3,) unit direction of travel."""
        return self._placed[1]

    @cached_property
    def _placed(self) -> tuple[Floats, Floats]:
        found: tuple[Floats, Floats] = _placed(self.edge.parameters, self.world_from_sensor)
        return found


@dataclass(frozen=True)
class _Ticks:
    """Many ticks, as arrays."""

    parameters: Floats  # (n, 6) of `Followed`
    covariances: Floats  # (n, 6, 6)
    sides: Floats  # (n,)
    poses: Floats  # (n, 4, 4) world_from_sensor

    @staticmethod
    def of(ticks: Sequence[EdgeTick]) -> "_Ticks":
        return _Ticks(
            np.array([tick.edge.parameters for tick in ticks]).reshape(-1, 6),
            np.array([tick.edge.covariance for tick in ticks]).reshape(-1, 6, 6),
            np.array([tick.edge.side for tick in ticks], dtype=float),
            np.array([tick.world_from_sensor for tick in ticks]).reshape(-1, 4, 4),
        )

    def __len__(self) -> int:
        return len(self.sides)

    def some(self, which: Bools) -> "_Ticks":
        """Those that a mask says."""
        return _Ticks(self.parameters[which], self.covariances[which], self.sides[which], self.poses[which])

    @cached_property
    def points(self) -> Floats:
        """(n, 3) [mm] of the edge beside the pad's center."""
        angle, offset, plateau = self.parameters[:, :3].T
        local = np.stack([-offset * np.sin(angle), offset * np.cos(angle), -plateau], axis=1)
        return np.asarray(np.einsum("nij,nj->ni", self.poses[:, :3, :3], local) + self.poses[:, :3, 3])

    @cached_property
    def travel(self) -> Floats:
        """(n,) [mm] along the edge: steps along the tangent, which the noise across it does not lengthen."""
        angle = self.parameters[:, 0]
        along = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        tangents = np.einsum("nij,nj->ni", self.poses[:, :3, :2], along)
        return travel_along(self.points, tangents)

    @cached_property
    def normals(self) -> Floats:
        """(n, 3) outward normal of the face."""
        angle, inward, along = self.parameters[:, [0, 3, 4]].T
        ca, sa = np.cos(angle), np.sin(angle)
        gx, gy = along * ca - self.sides * inward * sa, along * sa + self.sides * inward * ca
        tilt = np.stack([-gx, -gy, -np.ones_like(gx)], axis=1)
        out = np.einsum("nij,nj->ni", self.poses[:, :3, :3], tilt)
        return np.asarray(out / np.linalg.norm(out, axis=1, keepdims=True))


@dataclass(frozen=True)
class _Run:
    """The spline through a run of ticks."""

    spline: Spline  # (3) columns, [mm] over [mm]
    spread: float  # [mm] of the readings about it
    straight: bool  # whether nothing speaks for a bend


def smoothed(
    ticks: Sequence[EdgeTick],
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
    rows = _fitted_again(ticks, response, reach, drift)
    run = _drawn(rows)
    if run is None:
        return None
    travel = rows.travel
    first, last = float(travel.min()), float(travel.max())
    at = np.linspace(first, last, max(2, int(np.ceil((last - first) / SPACING)) + 1))
    along = run.spline.at(at, 1)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    order = np.argsort(travel)
    turned = np.stack([np.interp(at, travel[order], column[order]) for column in rows.normals.T], axis=1)
    turned -= np.sum(turned * along, axis=1, keepdims=True) * along
    turned /= np.linalg.norm(turned, axis=1, keepdims=True)
    per_point = max(1.0, len(rows) * SPACING / max(last - first, SPACING))
    sigma = np.full(len(at), run.spread / np.sqrt(per_point))
    return EdgeTrace(
        frozen(run.spline.at(at)), frozen(along), frozen(turned), frozen(sigma), closed, touch, stroke
    )


def _drawn(rows: _Ticks) -> _Run | None:
    """The spline through the ticks' points."""
    if len(rows) < LEAST:
        return None
    s, through, weight = in_order(
        rows.travel, KNOTS, rows.points, 1.0 / np.maximum(rows.covariances[:, 1, 1], 1e-4)
    )
    if len(s) < LEAST:
        return None
    readings = Readings(s, through, weight / weight.mean())
    stiffness = _stiffness(readings)
    spline = readings.smoothed(stiffness)
    off = rows.points - spline.at(rows.travel)
    return _Run(spline, float(off.std(axis=0).max()), stiffness >= STIFFNESSES[-1])


def _fitted_again(ticks: Sequence[EdgeTick], response: Response, reach: float, drift: float) -> _Ticks:
    """Every frame's edge once more, its bend smoothed; ticks that no longer fit drop out."""
    rows = _Ticks.of(ticks)
    if len(rows) < LEAST:
        return rows
    run = _drawn(rows)
    bends, sigmas = _bends(rows.travel, rows.parameters[:, 5], rows.covariances[:, 5, 5], drift)
    floor = BEND_SIGMA
    if run is not None and run.straight:
        bends, sigmas, floor = np.zeros_like(bends), np.zeros_like(sigmas), STRAIGHT
    change = np.maximum(0.0, _range_within(bends, rows.travel, reach) - 2.0 * BEND_SIGMA)
    near = np.clip(np.sqrt(6.0 * MOVED / np.maximum(change, 1e-9)), NEAREST, reach)
    near = np.minimum(near, 0.8 / np.maximum(np.abs(bends), 1e-6))
    lines = np.column_stack([rows.parameters[:, :2], rows.sides, bends])
    sure = np.maximum(np.maximum(sigmas, floor), change / 4.0)
    parameters, covariances, found = follow_lines([t.image for t in ticks], response, lines, sure, near)
    return _Ticks(parameters, covariances, rows.sides, rows.poses).some(found)


@numba.njit(cache=True, error_model="numpy")
def _placed(p: Floats, pose: Floats) -> tuple[Floats, Floats]:
    """(3,) point of the edge of (6,) parameters beside the pad's center, and its direction, in the world."""
    point, tangent = np.empty(3), np.empty(3)
    ca, sa = np.cos(p[0]), np.sin(p[0])
    for i in range(3):
        point[i] = pose[i, 3] + p[1] * (pose[i, 1] * ca - pose[i, 0] * sa) - p[2] * pose[i, 2]
        tangent[i] = pose[i, 0] * ca + pose[i, 1] * sa
    return point, tangent


@numba.njit(cache=True, error_model="numpy")
def _bends(travel: Floats, felt: Floats, variance: Floats, drift: float) -> tuple[Floats, Floats]:
    """Bend and its standard deviation [1/mm] at every tick, from the ticks before and behind."""
    bends, variances = felt.copy(), variance.copy()
    for k in range(len(bends) - 2, -1, -1):
        predicted = variances[k] + drift**2 * max(travel[k + 1] - travel[k], 0.0)
        gain = variances[k] / max(predicted, 1e-12)
        bends[k] += gain * (bends[k + 1] - bends[k])
        variances[k] += gain**2 * (variances[k + 1] - predicted)
    return bends, np.sqrt(np.maximum(variances, 0.0))


@numba.njit(cache=True, error_model="numpy")
def _range_within(values: Floats, travel: Floats, reach: float) -> Floats:
    """(n,) greatest less least of the values within `reach` of each."""
    out = np.empty(len(values))
    for k in range(len(values)):
        low = high = values[k]
        for j in range(len(values)):
            if abs(travel[j] - travel[k]) < reach:
                low, high = min(low, values[j]), max(high, values[j])
        out[k] = high - low
    return out


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
