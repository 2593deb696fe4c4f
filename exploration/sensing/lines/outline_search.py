"""Which lines and arcs a frame needs: hypotheses from the simplest on, fitted to all taxels, the likeliest kept.

Likeliest is the one of most evidence (`outline_evidence`), which asks of every line and arc more that it gain
what its numbers might have been otherwise.  Starts come from the Hough transform's peaks, from edge points split
by their normals, from circles through them, from the moments of a small contact, from bending a line that fits,
and from what the best hypothesis so far leaves unexplained.  The starts that fit best as they are take all steps.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations
from math import atan2, cos, dist, hypot, sin

import numpy as np

from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.edges import EdgePoints
from exploration.sensing.lines.line import normalized
from exploration.sensing.lines.outline_evidence import log_over, log_weight
from exploration.sensing.lines.outline_starts import (
    Circle,
    Straight,
    chains,
    circle_through,
    split_lines,
    tangents,
)
from exploration.sensing.lines.region import NO_TERMS, ONE, THREE, TWO, WHOLE, Region, Terms
from exploration.sensing.lines.region_fit import RegionFit, fit_region, unexplained
from exploration.sensing.lines.residual_starts import blob, dip, opposite, trough
from exploration.sensing.lines.seen import seen_of_disc, seen_of_line
from exploration.sensing.response import Response
from primitives.arrays import Floats

Start = tuple[Region, list[float]]
SAME = 1.0  # [mm] between circles that are not worth a try each


@dataclass(frozen=True)
class SearchConfig:
    """What is tried, and how long."""

    longest: float = 300.0  # [mm] radius from which an arc is a line, and
    nearly: float = 50.0  # [mm] from which it may be one
    bent: float = 100.0  # [mm] radius to which a line is bent
    polished: int = 2  # starts of each number of unknowns, at most
    settled: float = -0.5  # [standard deviations of chi2] within which, and with
    structure: float = 3.2  # [sigma] no patch of residuals greater than this, the search ends
    low: float = 0.1  # of the deepest taxel: a face that comes up to less at an edge runs out there
    open_arc: float = 2.0  # [rad] seen of an arc for each line that may stand for it
    holes: int = 2
    smallest: float = 0.35  # of the pad's short side: the radius up to which a contact may be a small disc


@dataclass(frozen=True)
class Evidence:
    """What the starts are made from."""

    image: TactileImage
    response: Response
    points: EdgePoints
    peaks: tuple[Straight, ...]  # of the Hough transform, most votes first
    most: int = 3  # lines


def search(evidence: Evidence, config: SearchConfig) -> tuple[RegionFit, RegionFit] | None:
    """The hypothesis of most evidence, and that of lines alone; None where nothing can be fitted."""
    best = fit_region(evidence.image, evidence.response, Region(), [])
    tried = [best]
    for stage in (_lone, _arcs, _pairs, _triples, _dips):
        if stage is _arcs or not _done(best, config):
            starts = list(stage(evidence, best, config))
            best = _likeliest(evidence, starts, best, tried, config, stage is _arcs)
    best = _likeliest(evidence, list(_straightened(best, config)), best, tried, config, True)
    if not best.converged:
        return None
    size = hypot(*evidence.image.array.size)
    straight = [fit for fit in tried if not fit.region.signs and fit.converged]
    return best, max(straight, key=lambda fit: log_weight(fit, size) + log_over(fit, best), default=best)


def _done(best: RegionFit, config: SearchConfig) -> bool:
    return best.settled(config.settled, config.structure) and not _lone_arc(best)


def _lone_arc(best: RegionFit) -> bool:
    """An arc, which two lines may stand for as well, however well it fits."""
    return len(best.region.signs) == 1 and not best.region.sides


def _likeliest(
    evidence: Evidence,
    starts: list[Start],
    best: RegionFit,
    tried: list[RegionFit],
    config: SearchConfig,
    always: bool = False,
) -> RegionFit:
    """The best of a stage: of each number of unknowns the starts that fit best as they are, to the end."""
    image, response = evidence.image, evidence.response
    size = hypot(*image.array.size)
    weight = log_weight(best, size) if starts and best.converged else 0.0
    glances: dict[int, list[RegionFit]] = {}
    for region, shape in starts:
        glances.setdefault(region.unknowns, []).append(fit_region(image, response, region, shape, 0))
    for _, fits in sorted(glances.items()):
        if _done(best, config) and not always:
            break
        for glance in sorted(fits, key=lambda fit: fit.chi2)[: config.polished]:
            fit = fit_region(image, response, glance.region, glance.parameters[3:])
            if fit.converged and not _runs_out(fit, image, config.low):
                tried.append(fit)
                other = log_weight(fit, size)
                if not best.converged or log_over(fit, best) + other > weight:
                    best, weight = fit, other
            if best is fit and fit.settled(config.settled, config.structure):
                break
    return best


def _runs_out(fit: RegionFit, image: TactileImage, low: float) -> bool:
    """Whether one of several lines lies where the face itself comes up to nothing."""
    p, sides = fit.parameters, fit.region.sides
    least = low * float(image.depth.max(where=np.isfinite(image.sigma), initial=0.0))
    for i in range(len(sides) if len(sides) > 1 else 0):
        angle, offset, _ = normalized(float(p[3 + 2 * i]), float(p[4 + 2 * i]), int(sides[i]))
        middle = 0.5 * sum(seen_of_line(fit.region, p, angle, offset, image.array.size))
        x, y = middle * cos(angle) - offset * sin(angle), middle * sin(angle) + offset * cos(angle)
        if p[0] + p[1] * x + p[2] * y < least:
            return True
    return False


def _lone(evidence: Evidence, best: RegionFit, config: SearchConfig) -> Iterable[Start]:
    for angle, offset, side in evidence.peaks[:1]:
        yield Region((side,), ONE[0]), [angle, offset]


def _arcs(evidence: Evidence, best: RegionFit, config: SearchConfig) -> Iterable[Start]:
    """One arc through all edge points, through each piece; a line bent; a rim inside a rim; a small disc."""
    points, image = evidence.points, evidence.image
    if len(best.region.sides) == 1 and not best.region.signs:
        angle, offset = best.parameters[3:5].tolist()
        for sign in (1.0, -1.0):
            away = offset + sign * best.region.sides[0] * config.bent
            bow = (-away * sin(angle), away * cos(angle), config.bent, sign)
            yield _arc(bow), list(bow[:3])
    whole = blob(image, evidence.response)
    if whole is not None and whole[2] < config.smallest * min(image.array.size):
        yield _arc(whole), list(whole[:3])
    if len(points) < 3:
        return
    pieces = chains(points, max(image.array.pitch))
    everything = np.ones(len(points), dtype=bool)
    circles = [circle_through(points, m, config.longest) for m in (everything, *pieces[:2])]
    tried: list[Circle] = []
    for circle in circles:
        if circle is not None and all(dist(circle, other) > SAME for other in tried):
            tried.append(circle)
            yield _arc(circle), list(circle[:3])
    outer = [c for c in circles[1:] if c is not None and c[3] > 0]
    inner = [c for c in circles[1:] if c is not None and c[3] < 0]
    if outer and inner:
        yield Region((), NO_TERMS, (1.0, -1.0)), [*outer[0][:3], *inner[0][:3]]


def _arc(circle: Circle) -> Region:
    return Region((), NO_TERMS if circle[3] > 0 else WHOLE, (circle[3],))


def _pairs(evidence: Evidence, best: RegionFit, config: SearchConfig) -> Iterable[Start]:
    return _joined(evidence, best, 2, TWO, config) if evidence.most > 1 else ()


def _triples(evidence: Evidence, best: RegionFit, config: SearchConfig) -> Iterable[Start]:
    """Three lines; also the best two, and the far side of the bar that either begins."""
    if evidence.most < 3:
        return
    yield from _joined(evidence, best, 3, THREE[:2], config)
    if len(best.region.sides) == 2 and not best.region.signs and best.region.terms == TWO[0]:
        image = evidence.image
        depth = np.where(np.isfinite(image.sigma), image.depth, 0.0)
        for i, side in enumerate(best.region.sides):
            angle, offset = best.parameters[3 + 2 * i : 5 + 2 * i].tolist()
            far = opposite((angle, offset, side), depth, image.array.x, image.array.y)
            yield Region((*best.region.sides, far[2]), THREE[0]), [*best.parameters[3:], *far[:2]]


def _joined(
    evidence: Evidence, best: RegionFit, count: int, ways: tuple[Terms, ...], config: SearchConfig
) -> Iterable[Start]:
    """So many lines joined: told apart by normals, by the Hough transform, or in an arc's stead."""
    sets = [split_lines(evidence.points, count, evidence.response.mean_width)]
    sets.extend(list(chosen) for chosen in combinations(evidence.peaks, count))
    if _lone_arc(best):
        disc = best.parameters[3:6]
        turn, step = seen_of_disc(best.region, best.parameters, disc, evidence.image.array.size)
        if len(turn) and step * len(turn) < config.open_arc * count:
            x, y, radius = disc.tolist()
            bow = (x, y, radius, best.region.signs[0])
            sets.append(tangents(bow, float(turn[0]), float(turn[-1]), count))
    for lines in sets:
        if len(lines) == count:
            shape = [value for line in lines for value in line[:2]]
            for terms in ways:
                yield Region(tuple(line[2] for line in lines), terms), shape


def _dips(evidence: Evidence, best: RegionFit, config: SearchConfig) -> Iterable[Start]:
    """A hole, or a slot, where the best so far reads too deep."""
    region, p, array = best.region, best.parameters, evidence.image.array
    if region.signs and region.signs[0] > 0 and len(region.signs) > 1:
        return
    left = unexplained(evidence.image, evidence.response, best)
    height = float(p[0])
    hole = dip(left, array.x, array.y, height, 2.5 * evidence.response.mean_width)
    if hole is not None and len(region.signs) < config.holes:
        yield Region(region.sides, region.terms, (*region.signs, -1.0)), [*p[3:], *hole[:3]]
    if region == Region():
        slot = trough(left, array.x, array.y, height, array.size)
        if slot:
            yield Region((slot[0][2], slot[1][2]), TWO[1]), [*slot[0][:2], *slot[1][:2]]


def _straightened(best: RegionFit, config: SearchConfig) -> Iterable[Start]:
    """A line in the stead of each arc that is nearly straight, beside holes; a wall for two such rims."""
    signs, p = best.region.signs, best.parameters
    if signs == (1.0, -1.0) and not best.region.sides and min(p[5], p[8]) > config.nearly:
        rims = [_tangent(p[3 + 3 * k : 6 + 3 * k], sign) for k, sign in enumerate(signs)]
        yield Region(tuple(side for *_, side in rims), TWO[0]), [v for rim in rims for v in rim[:2]]
    for k, sign in enumerate(signs):
        others = [i for i in range(len(signs)) if i != k]
        if best.region.sides or p[5 + 3 * k] < config.nearly or any(signs[i] > 0 for i in others):
            continue
        angle, offset, side = _tangent(p[3 + 3 * k : 6 + 3 * k], sign)
        rest = [value for i in others for value in p[3 + 3 * i : 6 + 3 * i]]
        yield Region((side,), ONE[0], tuple(signs[i] for i in others)), [angle, offset, *rest]


def _tangent(disc: Floats, sign: float) -> Straight:
    """The line that touches a circle where it is nearest the pad's center."""
    x, y, radius = disc.tolist()
    toward = atan2(-y, -x)
    return tangents((x, y, radius, sign), toward, toward, 1)[0]
