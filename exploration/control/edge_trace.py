"""From what each tick saw of an edge to where it ran.

Every tick yields one point of the edge, its direction and the face's normal, with the frame's noise and the
pose's.  Along the travel s each coordinate is smoothed by a cubic spline (scipy's `make_smoothing_spline`), as
stiff as cross-validation allows: of the splines through every other reading the one that misses the readings
between them least, or any stiffer one that misses them no more than noise explains.  A straight edge becomes a
straight line of all its ticks, a bent one keeps its bends.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import make_smoothing_spline

from primitives.arrays import Floats, frozen
from primitives.evidence import EdgeTrace

LEAST = 8  # ticks of a trace
SPACING = 1.0  # [mm] between the points of a trace
KNOTS = 240  # readings that the spline is fitted to; more are averaged in groups
STIFFNESSES = np.geomspace(1e-1, 1e8, 19)  # [mm^3] of the smoothing spline


@dataclass(frozen=True)
class EdgeTick:
    """The edge as one tick saw it, in the world."""

    point: Floats  # (3,) [mm] beside the pad's center
    tangent: Floats  # (3,) unit direction of travel
    inward: Floats  # (3,) unit direction in the face, into the material
    normal: Floats  # (3,) outward normal of the face
    bend: float  # [1/mm]
    sigma: float  # [mm] across the edge


def smoothed(ticks: list[EdgeTick], closed: bool, touch: int, stroke: int) -> EdgeTrace | None:
    """The trace through all ticks; None where they are too few."""
    if len(ticks) < LEAST:
        return None
    points = np.array([tick.point for tick in ticks])
    normals = np.array([tick.normal for tick in ticks])
    sigma = np.array([tick.sigma for tick in ticks])
    s = _travel(points, np.array([tick.tangent for tick in ticks]))
    order = np.argsort(s, kind="stable")
    s, points, normals, sigma = s[order], points[order], normals[order], sigma[order]
    size = max(1, int(np.ceil(len(s) / KNOTS)))
    s, points, normals, sigma = (_grouped(v, size) for v in (s, points, normals, sigma))
    apart = np.concatenate([[True], np.diff(s) > 1e-6])
    s, points, normals, sigma = s[apart], points[apart], normals[apart], sigma[apart]
    if len(s) < LEAST:
        return None
    weight = 1.0 / np.maximum(sigma, 1e-4) ** 2
    weight /= weight.mean()
    stiffness = _stiffness(s, points, weight)
    splines = [make_smoothing_spline(s, column, weight, stiffness) for column in points.T]
    at = np.linspace(s[0], s[-1], max(2, int(np.ceil((s[-1] - s[0]) / SPACING)) + 1))
    run = np.stack([spline(at) for spline in splines], axis=1)
    along = np.stack([spline.derivative()(at) for spline in splines], axis=1)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    turned = np.stack([np.interp(at, s, column) for column in normals.T], axis=1)
    turned -= np.sum(turned * along, axis=1, keepdims=True) * along
    turned /= np.linalg.norm(turned, axis=1, keepdims=True)
    spread = np.std(points - np.stack([spline(s) for spline in splines], axis=1), axis=0).max()
    per_point = max(1.0, len(s) * SPACING / max(s[-1] - s[0], SPACING))
    return EdgeTrace(
        frozen(run),
        frozen(along),
        frozen(turned),
        frozen(np.full(len(at), float(spread / np.sqrt(per_point)))),
        closed,
        touch,
        stroke,
    )


def _stiffness(s: Floats, points: Floats, weight: Floats) -> float:
    """The stiffness that predicts readings which it has not seen."""
    if len(s) < 4 * LEAST:
        return STIFFNESSES[-1]
    missed = []
    for stiffness in STIFFNESSES:
        squares = []
        for used, held in ((slice(0, None, 2), slice(1, -1, 2)), (slice(1, None, 2), slice(2, -1, 2))):
            for column in points.T:
                spline = make_smoothing_spline(s[used], column[used], weight[used], stiffness)
                squares.append(weight[held] * (spline(s[held]) - column[held]) ** 2)
        missed.append(np.concatenate(squares))
    means = np.array([m.mean() for m in missed])
    best = int(np.argmin(means))
    allowed = means[best] + missed[best].std() / np.sqrt(len(missed[best]))
    return float(STIFFNESSES[int(np.flatnonzero(means <= allowed).max())])


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
