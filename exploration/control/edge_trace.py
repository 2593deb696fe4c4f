"""From what each tick saw of an edge to where it ran.

Every tick yields one point of the edge, its direction and the face's normal, with the frame's noise and the
pose's.  Along the travel s each coordinate is smoothed by a cubic spline (`smoothing_spline`), as stiff as
cross-validation allows: of the splines through every other reading, the one that misses the readings between them
least.  A straight edge becomes a straight line of all its ticks, a bent one keeps its bends.

While tracking, the bend of an edge is filtered from what lies behind, and lags where it changes.  Afterwards it is
smoothed from both sides (Rauch, Tung and Striebel, for a random walk); every frame is fitted once more with it,
and over less of the edge where it changes: a change of c [1/mm] within a reach r moves the fit by up to c r^2 / 6.
The curve of a bent edge is at last compared with all frames, taxel by taxel (`edge_refined`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numba
import numpy as np

from exploration.control.edge_refined import Frames, moved_outward, nodes_along
from exploration.control.edge_ticks import EdgeTick, Ticks
from exploration.control.smoothing_spline import Readings, Spline, in_order
from exploration.sensing.lines.follow_line import follow_lines
from exploration.sensing.response import Response
from primitives.arrays import Floats, Ints, frozen
from primitives.evidence import EdgeTrace

LEAST = 8  # ticks of a trace
SPACING = 1.0  # [mm] between the points of a trace
KNOTS = 240  # readings that the spline is fitted to; more are averaged in groups
STIFFNESSES = (*np.geomspace(1e-2, 1e6, 9), np.inf)  # [mm^3] of the smoothing spline; a line at the end
SLACK = 0.002  # share by which a stiffer spline may miss more
SHORT = 30.0  # [mm] an edge is straight unless its readings clearly say otherwise,
UNBENT = 0.006  # [1/mm] or its frames, which know their mean bend many times as well
BEND_SIGMA = 0.002  # [1/mm] least to which a smoothed bend is known
STRAIGHT = 1e-4  # [1/mm] the same, of an edge that is straight
MOVED = 0.03  # [mm] by which a changing bend may move a fit
REFINED = 2  # times that a bent edge is moved to what its frames say
NEAREST = 4.0  # [mm] of the edge, either way, that a fit needs


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
    before: Sequence[EdgeTick] = (),
    after: Sequence[EdgeTick] = (),
) -> EdgeTrace | None:
    """The trace through all ticks; None where they are too few.

    Ticks `before` and `after` them bend its ends and are no part of it.  `reach` [mm] of the edge, either way, are
    fitted in a frame; its bend changes by `drift` [1/mm] within a mm.
    """
    given = len(before) + np.arange(len(ticks))
    rows, kept = _fitted_again([*before, *ticks, *after], response, reach, drift)
    own = np.isin(kept, given)
    run = _drawn(rows)
    if run is None or not own.any():
        return None
    travel = rows.travel
    first, last = float(travel[own].min()), float(travel[own].max())
    if not run.straight:
        run = _refined(run, rows, response)
    at = np.linspace(first, last, max(2, int(np.ceil((last - first) / SPACING)) + 1))
    along = run.spline.at(at, 1)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    order = np.argsort(travel)
    turned = np.stack([np.interp(at, travel[order], column[order]) for column in rows.normals.T], axis=1)
    turned -= np.sum(turned * along, axis=1, keepdims=True) * along
    turned /= np.linalg.norm(turned, axis=1, keepdims=True)
    per_point = max(1.0, own.sum() * SPACING / max(last - first, SPACING))
    sigma = np.full(len(at), run.spread / np.sqrt(per_point))
    return EdgeTrace(
        frozen(run.spline.at(at)), frozen(along), frozen(turned), frozen(sigma), closed, touch, stroke
    )


def _drawn(rows: Ticks) -> _Run | None:
    """The spline through the ticks' points."""
    if len(rows) < LEAST:
        return None
    s, through, weight = in_order(
        rows.travel, KNOTS, rows.points, 1.0 / np.maximum(rows.covariances[:, 1, 1], 1e-4)
    )
    if len(s) < LEAST:
        return None
    readings = Readings(s, through, weight / weight.mean())
    stiffness = _stiffness(readings, float(np.median(rows.parameters[:, 5])))
    spline = readings.smoothed(stiffness)
    off = rows.points - spline.at(rows.travel)
    return _Run(spline, float(off.std(axis=0).max()), stiffness >= STIFFNESSES[-1])


def _refined(run: _Run, rows: Ticks, response: Response) -> _Run:
    """The spline of a bent edge, moved to where the frames' taxels say that it runs."""
    travel = rows.travel
    at = nodes_along(float(travel.min()), float(travel.max()))
    frames = Frames(
        np.array([image.depth for image in rows.images]),
        np.array([image.sigma for image in rows.images]),
        rows.images[0].array.pitch,
        rows.poses,
        rows.parameters[:, 2:4],
        float(rows.sides[0]),
        travel,
    )
    order = np.argsort(travel)
    normals = np.stack([np.interp(at, travel[order], column[order]) for column in rows.normals.T], axis=1)
    spline = run.spline
    for _ in range(REFINED):
        curve = spline.at(at)
        along = spline.at(at, 1)
        outward = -frames.side * np.cross(along, normals)
        outward /= np.linalg.norm(outward, axis=1, keepdims=True)
        off, information = moved_outward(curve, frames, float(at[0]), response)
        known = information > 0.0
        if known.sum() < LEAST:
            return run
        readings = Readings(
            at[known], (curve + off[:, None] * outward)[known], information[known] / information[known].mean()
        )
        spline = readings.smoothed(_stiffness(readings, np.inf))
    return replace(run, spline=spline)


def _fitted_again(
    ticks: Sequence[EdgeTick], response: Response, reach: float, drift: float
) -> tuple[Ticks, Ints]:
    """Every frame's edge once more, its bend smoothed; ticks that no longer fit drop out; the others' numbers."""
    rows = Ticks.of(ticks)
    if len(rows) < LEAST:
        return rows, np.arange(len(rows))
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
    parameters, covariances, found = follow_lines(rows.images, response, lines, sure, near)
    fitted = replace(rows, parameters=parameters, covariances=covariances)
    return fitted.some(found), np.flatnonzero(found)


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


def _stiffness(readings: Readings, bend: float) -> float:
    """The stiffness that predicts readings which it has not seen, of an edge whose frames show a `bend` [1/mm]."""
    s = readings.places
    if len(s) < 4 * LEAST:
        return float(STIFFNESSES[-1])
    missed = [readings.missed(float(stiffness)) for stiffness in STIFFNESSES]
    unbent = s[-1] - s[0] < SHORT and abs(bend) < UNBENT
    if unbent and missed[-1] <= (1.0 + 2.0 / np.sqrt(len(s))) * min(missed):
        return float(STIFFNESSES[-1])
    best = np.flatnonzero(np.array(missed) <= (1.0 + SLACK) * min(missed))
    return float(STIFFNESSES[int(best.max())])
