"""Lines of a frame: one straight edge at once, or the Modified Adaptive Hough Transform and a polish of its peaks.

Most frames show one edge or none, and `single_edge` is sure of that in one kernel.  Most others show the outline
of a flat face, several lines at once (`outline`).  In what is left, peaks of the votes (`hough_votes`) are
extracted one after another, each taking its points away, and each is fitted to the sensor model with the surface
around it (`line_fit`, `line_evidence`).

A line is reported only where the depth drops below what the local surface predicts: a rim that a smooth paraboloid
explains as well (sphere, cylinder, tilted face running out) is no edge.  "No line" is the usual answer.
"""

from dataclasses import dataclass
from math import cos, hypot, inf, pi, sin, sqrt

import numpy as np

from exploration.sensing.contact_mask import usable
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.edges import EdgePoints, edge_points
from exploration.sensing.lines.hough_votes import find_peak, members_of
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
from exploration.sensing.lines.outline import UNMISTAKABLE, find_outline
from exploration.sensing.lines.single_edge import DOUBTFUL, single_edge
from exploration.sensing.response import Response, response_of
from exploration.sensing.surfaces.footprint import Footprint
from primitives.arrays import Bools, Floats
from primitives.errors import PalpateError


@dataclass(frozen=True)
class HoughConfig:
    """What counts as a line."""

    direction_tolerance: float = 0.45  # [rad] of a point's gradient from the line's normal
    band: float = 0.7  # [response widths] within which a point belongs to a line
    least_votes: float = 2.0  # sum of weights
    least_length: float = 1.6  # [taxels] seen
    least_strength: float = 5.0  # [sigma] of the step's height
    least_share: float = 0.1  # of the deepest taxel, at the edge: a plane that runs out ends in less
    least_step: float = 0.6  # of the deepest taxel, at the edge, for a line to need no comparison
    many: int = 7  # edge points on a line that is compared with a straight rim
    plenty: int = 9  # edge points on a line that needs no comparison with a paraboloid
    clear: float = 25.0  # [chi2] more than it is worth, by which it fits better than a rim without a step
    greatest_misfit: float = 3.0  # [standard deviations of chi2] before a single line is doubted


DEFAULT = HoughConfig()
Peak = tuple[float, float, int, Bools]  # angle, offset, material side, member points


def find_lines(
    image: TactileImage,
    max_lines: int = 3,
    response: Response | None = None,
    config: HoughConfig | None = None,
    dihedral: float = pi / 2,
) -> tuple[Line, ...]:
    """The straight edges of a frame, strongest first; empty where there is none.

    `dihedral` [rad] is the angle between an edge's two faces.  No single frame tells a wider one than a right
    angle from more blur: not told, an edge of 120 or 150 degrees pressed z0 deep is placed
    z0 tan(dihedral - pi/2) / 2 too far outside, 0.14 or 0.43 mm at 0.5 mm.
    """
    config = config or DEFAULT
    if image.depth.shape != image.array.shape or image.sigma.shape != image.array.shape:
        raise PalpateError(
            f"image of {image.depth.shape} taxels and {image.sigma.shape} sigmas on array {image.array.name} "
            f"{image.array.shape}: make it by `correct` with the array's own calibration"
        )
    if not usable(image):
        return ()
    response = response_of(image, response)
    verdict, line = single_edge(image, response, dihedral)
    if verdict != DOUBTFUL:
        return () if line is None else (line,)
    outline = find_outline(image, max_lines, response, UNMISTAKABLE)
    explained = outline.explains(config.greatest_misfit) and not outline.arcs
    return (
        _high(image, outline.lines, config) if explained else voted_lines(image, max_lines, response, config)
    )


def voted_lines(
    image: TactileImage,
    max_lines: int = 3,
    response: Response | None = None,
    config: HoughConfig = DEFAULT,
) -> tuple[Line, ...]:
    """The lines of a frame that no flat face's outline explains: rims, and edges of curved faces."""
    return _high(image, _searched(image, max_lines, response_of(image, response), config), config)


def _high(image: TactileImage, lines: tuple[Line, ...], config: HoughConfig) -> tuple[Line, ...]:
    """Without the low ends of planes that run out."""
    low = config.least_share * float(image.depth.max())
    return tuple(line for line in lines if line.plateau > low)


def _searched(
    image: TactileImage, max_lines: int, response: Response, config: HoughConfig
) -> tuple[Line, ...]:
    points = edge_points(image, response)
    found = candidates(points, image, max_lines, response, config)
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
    image: TactileImage, points: EdgePoints, found: list[Peak], joint: JointFit, config: HoughConfig
) -> tuple[Line, ...]:
    """The lines of a joint fit, strongest first; none if it did not converge."""
    if not joint.fit.converged:
        return ()
    lines = []
    least = config.least_length * min(image.array.pitch)
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


def _inflation(fit: LineFit | Footprint) -> float:
    return max(1.0, fit.chi2 / max(1, fit.dof))


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


def candidates(
    points: EdgePoints, image: TactileImage, max_lines: int, response: Response, config: HoughConfig
) -> list[Peak]:
    """(angle, offset, material side, member points) of each peak, most votes first."""
    found: list[Peak] = []
    left = np.array(points.weight)
    reach = 0.5 * hypot(*image.array.size)
    band = config.band * response.mean_width
    least = config.least_length * min(image.array.pitch)
    for _ in range(max_lines):
        if len(points) < 2 or left.sum() < config.least_votes:
            break
        angle, offset = find_peak(points.points, points.directions, left, reach, config.direction_tolerance)
        members, votes, length, toward = members_of(
            points.points, points.directions, left, angle, offset, band, config.direction_tolerance
        )
        if votes < config.least_votes:
            break
        left[members] = 0.0
        if length >= least:
            angle, offset, side = normalized(angle, offset, 1 if toward > 0 else -1)
            found.append((angle, offset, side, members))
    return found


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
        _read_only(spread),
        high - low,
        _read_only(np.array([low * ca - offset * sa, low * sa + offset * ca])),
        _read_only(np.array([high * ca - offset * sa, high * sa + offset * ca])),
        height / sqrt(height_variance * inflation),
        turned_side,
        height,
    )


def _read_only(array: Floats) -> Floats:
    array.flags.writeable = False
    return array
