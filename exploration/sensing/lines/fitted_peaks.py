"""Peaks of the votes, each fitted to the sensor model with the surface around it, as lines.

A line is reported only where the depth drops below what the local surface predicts: a rim that a smooth paraboloid
explains as well (sphere, cylinder, tilted face running out) is no edge.
"""

from dataclasses import dataclass, field
from math import cos, inf, sin, sqrt

import numpy as np

from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.edges import EdgePoints, edge_points
from exploration.sensing.lines.line import Line, clipped, normalized
from exploration.sensing.lines.line_evidence import (
    JointFit,
    beats_rim,
    beats_smooth,
    fit_lines,
    polish,
    worth,
)
from exploration.sensing.lines.line_fit import LineFit, fit_line, softened
from exploration.sensing.lines.peaks import Peak, PeakConfig, peaks
from exploration.sensing.response import Response
from exploration.sensing.surfaces.footprint import Footprint
from primitives.arrays import Bools, Floats, frozen


@dataclass(frozen=True)
class HoughConfig:
    """What counts as a line."""

    peaks: PeakConfig = field(default_factory=PeakConfig)
    least_strength: float = 5.0  # [sigma] of the step's height
    least_share: float = 0.1  # of the deepest taxel, at the edge: a plane that runs out ends in less
    least_step: float = 0.6  # of the deepest taxel, at the edge, for a line to need no comparison
    many: int = 7  # edge points on a line that is compared with a straight rim
    plenty: int = 9  # edge points on a line that needs no comparison with a paraboloid
    clear: float = 25.0  # [chi2] more than it is worth, by which it fits better than a rim without a step
    greatest_misfit: float = 3.0  # [standard deviations of chi2] before a single line is doubted


DEFAULT = HoughConfig()


def fitted_peaks(
    image: TactileImage, max_lines: int, response: Response, config: HoughConfig
) -> tuple[Line, ...]:
    """The lines of what the edge points vote for, strongest first."""
    points = edge_points(image, response)
    found = peaks(points, image, max_lines, response, config.peaks)
    if not found:
        return ()
    soft = softened(image)
    angle, offset, side, members = found[0]
    fit = fit_line(soft, response, angle, offset, side)
    alone = len(found) == 1
    rim = _rim(soft, response, fit, side, members, config)
    lead = -inf
    if rim is not None:
        gain = (rim.chi2 - fit.chi2) / _inflation(fit) - worth(-float(rim.parameters[3]))
        sure = rim.converged or gain > 10 * config.clear
        lead = gain
        if fit.chi2 < fit.dof + config.greatest_misfit * sqrt(2 * max(1, fit.dof)):
            single = None if soft is image else polish(image, fit, side)
            chi2 = fit.chi2 if single is None else single.fit.chi2
            if sure and alone and gain > config.clear and int(members.sum()) >= config.plenty:
                likelier = True
            elif sure and alone and 0.0 < gain <= config.clear:
                likelier = beats_rim(image, chi2, rim, side)
            else:
                likelier = (gain > 0.0 or not sure) and beats_smooth(image, chi2)
            if likelier and single is None:
                return (_single(image, points, members, fit, side),)
            if likelier and single is not None:
                return _joined(image, points, found[:1], single, config)
            if alone:
                return ()
    joint = fit_lines(image, [peak[:3] for peak in found], lead > 0.0 and alone)
    return _joined(image, points, found, joint, config) if joint else ()


def _joined(
    image: TactileImage, points: EdgePoints, found: tuple[Peak, ...], joint: JointFit, config: HoughConfig
) -> tuple[Line, ...]:
    """The lines of a joint fit, strongest first; none if it did not converge."""
    if not joint.fit.converged:
        return ()
    lines = []
    least = config.peaks.least_length * min(image.array.pitch)
    for place, k in enumerate(joint.chosen):
        rows = [6 + 2 * place, 7 + 2 * place]
        angle, offset = joint.fit.parameters[rows].tolist()
        covariance = joint.fit.covariance[np.ix_(rows, rows)]
        _, _, side, members = found[k]
        at = np.array([1.0, *points.points[members].mean(axis=0)])
        height = float(at @ joint.fit.parameters[:3])
        variance = float(at @ joint.fit.covariance[:3, :3] @ at)
        inflation = _inflation(joint.fit)
        lines.append(
            _line(image, points, members, side, angle, offset, covariance, height, variance, inflation)
        )
    strong = [line for line in lines if line.strength > config.least_strength and line.length >= least]
    return tuple(sorted(strong, key=lambda line: -line.strength))


def _rim(
    image: TactileImage, response: Response, fit: LineFit, side: int, members: Bools, config: HoughConfig
) -> LineFit | None:
    """The best straight rim without a step beside one long line on a high plateau; none if it is not that."""
    if not fit.converged or members.sum() < config.many:
        return None
    height, sigma = float(fit.parameters[2]), sqrt(fit.covariance[2, 2])
    if height - 2 * sigma < config.least_step * float(image.depth.max()):
        return None
    angle, offset = float(fit.parameters[0]), float(fit.parameters[1])
    outside = offset - side * response.width((-sin(angle), cos(angle)))
    return fit_line(image, response, angle, outside, side, order=1)


def _inflation(fit: LineFit | Footprint) -> float:
    return max(1.0, fit.chi2 / max(1, fit.dof))


def _single(image: TactileImage, points: EdgePoints, members: Bools, fit: LineFit, side: int) -> Line:
    """The line of a fit by itself, its height taken in the middle of the points that support it."""
    angle, offset, height, _, along = fit.parameters.tolist()
    c = fit.covariance
    middle = float((points.points[members] @ (cos(angle), sin(angle))).mean())
    variance = c[2, 2] + 2 * middle * c[2, 4] + middle**2 * c[4, 4]
    return _line(
        image,
        points,
        members,
        side,
        angle,
        offset,
        c[:2, :2],
        height + along * middle,
        variance,
        _inflation(fit),
    )


def _line(
    image: TactileImage,
    points: EdgePoints,
    members: Bools,
    side: int,
    angle: float,
    offset: float,
    covariance: Floats,
    height: float,
    height_variance: float,
    inflation: float,
) -> Line:
    """A fitted line, over the length where the pad saw it."""
    angle, offset, turned_side = normalized(angle, offset, side)
    sx, sy = image.array.size
    low, high = clipped(angle, offset, (sx / 2, sy / 2))
    ca, sa = cos(angle), sin(angle)
    along = points.points[members] @ (ca, sa)
    grow = max(image.array.pitch)
    low, high = max(low, float(along.min()) - grow), min(high, float(along.max()) + grow)
    high = max(low, high)
    spread = covariance * inflation
    if turned_side != side:
        spread[0, 1] = spread[1, 0] = -spread[0, 1]
    return Line(
        angle,
        offset,
        frozen(spread),
        high - low,
        frozen(np.array([low * ca - offset * sa, low * sa + offset * ca])),
        frozen(np.array([high * ca - offset * sa, high * sa + offset * ca])),
        height / sqrt(height_variance * inflation),
        turned_side,
        height,
    )
