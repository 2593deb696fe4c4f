"""The outline of the face under the pad: lines and arcs that compete by likelihood for one frame.

Every hypothesis is a `Region`, fitted to all taxels at once in closed form (`region_fit`): one line; an arc,
of which a line is the limit; two and three lines, joined in all ways; a rim inside a rim; holes in what was found.
Each line or arc more must gain `WORTH` in chi2, and a hypothesis that explains the frame ends the search.
What a smooth surface explains as well has no outline: "nothing" is an answer.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations
from math import hypot, sqrt

import numpy as np

from exploration.sensing.contact_mask import contact_mask, usable
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.arc import Arc
from exploration.sensing.lines.edges import EdgePoints, edge_points
from exploration.sensing.lines.hough import DEFAULT, HoughConfig, Peak, candidates
from exploration.sensing.lines.line import Line, normalized
from exploration.sensing.lines.line_evidence import worth
from exploration.sensing.lines.line_fit import softened
from exploration.sensing.lines.outline_starts import (
    Circle,
    blob,
    chains,
    circle_through,
    seen_of_disc,
    seen_of_line,
)
from exploration.sensing.lines.region import NO_TERMS, ONE, THREE, TWO, WHOLE, Region
from exploration.sensing.lines.region_fit import RegionFit, fit_region
from exploration.sensing.response import Response, response_of
from exploration.sensing.surfaces.local_surface import fit_paraboloid
from primitives.arrays import Floats, frozen


@dataclass(frozen=True)
class OutlineConfig:
    """What counts as found."""

    worth: float = 25.0  # [chi2] that each further line or arc must gain
    bend: float = 12.0  # [chi2] that an arc must gain on a line (99.9 %, with BIC's price for one number)
    explained: float = 3.0  # [standard deviations of chi2] within which a hypothesis ends the search
    strength: float = 5.0  # [sigma] of the step's height
    longest: float = 300.0  # [mm] radius from which an arc is called a line
    length: float = 1.6  # [taxels] of a line that is seen
    holes: int = 2


@dataclass(frozen=True)
class Outline:
    """Edges of one frame; false where there are none."""

    lines: tuple[Line, ...] = ()
    arcs: tuple[Arc, ...] = ()
    chi2: float = 0.0
    dof: int = 0

    def __bool__(self) -> bool:
        return bool(self.lines or self.arcs)


NOTHING = Outline()


def find_outline(
    image: TactileImage,
    max_lines: int = 3,
    response: Response | None = None,
    config: OutlineConfig = OutlineConfig(),
    hough: HoughConfig = DEFAULT,
) -> Outline:
    """Straight edges and arcs of a frame, each kind strongest first."""
    if not usable(image):
        return NOTHING
    response = response_of(image, response)
    points = edge_points(image, response)
    soft = softened(image)
    peaks = candidates(points, image, max_lines, response, hough)
    best = _search(soft, points, peaks, response, config)
    if best is None or not best.converged or _smooth_is_likelier(image, best):
        return NOTHING
    return _report(soft, best, config)


def _search(
    image: TactileImage,
    points: EdgePoints,
    peaks: list[Peak],
    response: Response,
    config: OutlineConfig,
) -> RegionFit | None:
    """The hypothesis of the best price, from the simplest on."""
    best: RegionFit | None = None
    for stage in (_lone, _arcs, _pairs, _triples, _holes):
        for region, shape in stage(image, points, peaks, best, response, config):
            fit = fit_region(image, response, region, shape)
            if fit.converged and (best is None or _price(fit, config) < _price(best, config)):
                best = fit
        if best is not None and stage is not _lone and best.explains(config.explained):
            break
    return best


Starts = Iterable[tuple[Region, list[float]]]


def _price(fit: RegionFit, config: OutlineConfig) -> float:
    lines, arcs = len(fit.region.sides), len(fit.region.signs)
    return fit.chi2 + config.worth * (lines + arcs) + config.bend * arcs


def _lone(
    image: TactileImage,
    points: EdgePoints,
    peaks: list[Peak],
    best: RegionFit | None,
    response: Response,
    config: OutlineConfig,
) -> Starts:
    if peaks:
        angle, offset, side, _ = peaks[0]
        yield Region((float(side),), ONE[0]), [angle, offset]


def _arcs(
    image: TactileImage,
    points: EdgePoints,
    peaks: list[Peak],
    best: RegionFit | None,
    response: Response,
    config: OutlineConfig,
) -> Starts:
    """One arc through all edge points, through each piece; a rim inside a rim; a blob."""
    if len(points) < 3:
        return
    pieces = chains(points, max(image.array.pitch))
    everything = np.ones(len(points), dtype=bool)
    sets = [everything, *(m for m in pieces[:2] if not m.all())]
    circles = [circle_through(points, m, config.longest) for m in sets]
    for circle in circles:
        if circle is not None:
            yield _arc(circle), list(circle[:3])
    inner, outer = [c for c in circles[1:] if c and c[3] < 0], [c for c in circles[1:] if c and c[3] > 0]
    if inner and outer:
        yield Region((), NO_TERMS, (1.0, -1.0)), [*outer[0][:3], *inner[0][:3]]
    whole = blob(np.maximum(image.depth, 0.0), image.array.x, image.array.y, response.variance)
    if whole is not None and whole[2] < 0.3 * min(image.array.size):
        yield _arc(whole), list(whole[:3])


def _arc(circle: Circle) -> Region:
    return Region((), NO_TERMS if circle[3] > 0 else WHOLE, (circle[3],))


def _pairs(
    image: TactileImage,
    points: EdgePoints,
    peaks: list[Peak],
    best: RegionFit | None,
    response: Response,
    config: OutlineConfig,
) -> Starts:
    return _joined(peaks, 2)


def _triples(
    image: TactileImage,
    points: EdgePoints,
    peaks: list[Peak],
    best: RegionFit | None,
    response: Response,
    config: OutlineConfig,
) -> Starts:
    return _joined(peaks, 3)


def _joined(peaks: list[Peak], count: int) -> Starts:
    for chosen in combinations(peaks, count):
        sides = tuple(float(peak[2]) for peak in chosen)
        shape = [value for peak in chosen for value in peak[:2]]
        for terms in (TWO, THREE)[count - 2]:
            yield Region(sides, terms), shape


def _holes(
    image: TactileImage,
    points: EdgePoints,
    peaks: list[Peak],
    best: RegionFit | None,
    response: Response,
    config: OutlineConfig,
) -> Starts:
    """A hole where the best so far, or a whole face, reads most too deep."""
    return ()


def _smooth_is_likelier(image: TactileImage, best: RegionFit) -> bool:
    smooth = fit_paraboloid(image, contact_mask(image))
    kxx, kxy, kyy = smooth.parameters[3:6]
    mean, half = (kxx + kyy) / 2, hypot((kxx - kyy) / 2, kxy)
    needed = worth(mean + half, mean - half)
    return smooth.converged and smooth.chi2 - best.chi2 < needed


def _report(image: TactileImage, fit: RegionFit, config: OutlineConfig) -> Outline:
    """Lines and arcs of a fit, over what the pad sees of them."""
    lines, arcs = [], []
    p, covariance = fit.parameters, fit.covariance * fit.inflation
    size = image.array.size
    n = len(fit.region.sides)
    for i, side in enumerate(fit.region.sides):
        rows = slice(3 + 2 * i, 5 + 2 * i)
        angle, offset, turned = normalized(float(p[rows.start]), float(p[rows.start + 1]), int(side))
        shared = np.array(covariance[rows, rows])
        if turned != int(side):
            shared[0, 1] = shared[1, 0] = -shared[0, 1]
        low, high = seen_of_line(fit.region, p, angle, offset, size)
        e, normal = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        ends = [frozen(v * e + offset * normal) for v in (low, high)]
        height, strength = _height(p, covariance, 0.5 * (ends[0] + ends[1]))
        line = Line(angle, offset, frozen(shared), high - low, *ends, strength, turned, height)
        if strength > config.strength and line.length > config.length * min(image.array.pitch):
            lines.append(line)
    for k, sign in enumerate(fit.region.signs):
        rows = slice(3 + 2 * n + 3 * k, 6 + 2 * n + 3 * k)
        span, middle = seen_of_disc(fit.region, p, p[rows], size)
        height, strength = _height(p, covariance, middle)
        shared = frozen(covariance[rows, rows])
        center, radius = frozen(p[rows][:2]), float(p[rows][2])
        if strength > config.strength and span > 0.0:
            arcs.append(Arc(center, radius, shared, sign > 0, span, strength, height))
    lines.sort(key=lambda line: -line.strength)
    arcs.sort(key=lambda arc: -arc.strength)
    return Outline(tuple(lines), tuple(arcs), fit.chi2, fit.dof)


def _height(p: Floats, covariance: Floats, at: Floats) -> tuple[float, float]:
    """Depth of the face [mm] at a point, and the same in standard deviations."""
    m = np.array([1.0, at[0], at[1]])
    height = float(m @ p[:3])
    return height, height / sqrt(max(1e-18, float(m @ covariance[:3, :3] @ m)))
