"""Readings of a frame as a face that lines or arcs cut, for the evidence of its kind (`kinds`).

A reading holds chi2 at its best and the log of what the frame leaves of its unknowns' range, log det(2 pi C)/2 +
log p.  Before touch lines are even over the pad in angle and offset, the two of a wall parallel to `ASKEW`; an
arc's center is even over the pad's diagonal squared, its radius in log; a cut face is curved with `BENT_FACE`.

Faces are flat and fitted in closed form (`region_fit`); on a skin that ends soon, what is near enough is polished
on that skin (`short_skin`).
"""

from dataclasses import dataclass
from math import hypot, inf, log, pi, sin, sqrt

import numpy as np

from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.edges import edge_points
from exploration.sensing.lines.line_fit import softened
from exploration.sensing.lines.outline import Outline
from exploration.sensing.lines.outline_starts import circle_through
from exploration.sensing.lines.peaks import peaks
from exploration.sensing.lines.region import NO_TERMS, ONE, THREE, TWO, WHOLE, Region
from exploration.sensing.lines.region_fit import RegionFit, fit_region
from exploration.sensing.lines.short_skin import on_its_skin
from exploration.sensing.response import response_of
from exploration.sensing.surfaces.footprint import Footprint
from exploration.sensing.surfaces.order import Ordered
from exploration.sensing.surfaces.smooth_shapes import RIDGE
from primitives.arrays import Floats

PARALLEL = 0.3  # [sine of the angle] between the two edges of a ridge
SLOPE = 0.1  # standard deviation of a pad's slope on a face before touch
TURNED = 0.25  # sqrt(2 pi) of that: what a density of 1 / TURNED is even over
BENT_FACE = 0.2  # probability that a face with edges under the pad is curved
NARROW = 0.7  # [pad's short side] a ridge narrower than this may be a wall with two edges
SETTLED = 20.0  # [chi2] by which a reading behind the best is out of the question
ASKEW = 0.01  # [rad] by which the edges of a wall are not parallel
LONGEST = 100.0  # [mm] radius from which an arc is taken for a line
CYLINDRIC = 0.3  # of the greater curvature, that the lesser of a narrow ridge is at most
BOX = 0.8  # of a parabola's half width: half the width of a box that holds as much
LEVEL = -log(2.0) - 2 * log(TURNED)  # log density of a depth and two slopes
_UNIONS = (TWO[1], THREE[1])


@dataclass(frozen=True)
class Reading:
    """One way to understand a frame."""

    kind: str
    chi2: float
    dof: int
    volume: float  # log of what is left of the range of its lines
    fit: RegionFit | None = None


def reading_of_lines(image: TactileImage, fit: Footprint) -> Reading:
    """What lines cut out of a plane or dome say."""
    angles = fit.parameters[6::2]
    n = len(angles)
    bent = bool(fit.covariance[3:6, 3:6].any())
    free = [0, 1, 2, *([3, 4, 5] if bent else []), *range(6, 6 + 2 * n)]
    covariance = fit.covariance[np.ix_(free, free)]
    kind, density = _of_lines(image, angles, covariance, False)
    if bent:
        density += log(BENT_FACE) - 3 * log(TURNED)
    return Reading(kind, fit.chi2, fit.dof, density + _volume(covariance))


def reading_of_region(image: TactileImage, fit: RegionFit) -> Reading:
    """What an outline of lines and arcs says."""
    n, radii = len(fit.region.sides), fit.parameters[5 + 2 * len(fit.region.sides) :: 3]
    union = fit.region.terms in _UNIONS
    angles = fit.parameters[3 : 3 + 2 * n : 2]
    kind, density = _of_lines(image, angles, fit.covariance[: 3 + 2 * n, : 3 + 2 * n], union)
    if len(radii):
        kind = "edge" if n + len(radii) == 1 else "corner"
    reach = hypot(*image.array.size)
    for radius in radii.tolist():
        density -= 2 * log(reach) + log(max(radius, 1.0) * log(100.0))
    return Reading(kind, fit.chi2, fit.dof, density + _volume(fit.covariance), fit)


def readings_of_outline(image: TactileImage, outline: Outline) -> list[Reading]:
    """The outline's own reading, and those with one line less, if it has several."""
    fit = outline.fit
    if fit is None:
        return []
    out = [reading_of_region(image, fit)]
    n = len(fit.region.sides)
    if fit.region.signs or n < 2:
        return out
    terms = ONE[0] if n == 2 else TWO[int(fit.region.terms in _UNIONS)]
    for k in range(n):
        sides = tuple(side for i, side in enumerate(fit.region.sides) if i != k)
        shape = np.delete(fit.parameters[3:], [2 * k, 2 * k + 1])
        less = _fitted(image, Region(sides, terms), shape, inf)
        if less is not None:
            out.append(less)
    return out


def rivals(image: TactileImage, ordered: Ordered) -> list[Reading]:
    """What the two strongest straight rims of a frame, as an edge each and as a corner, and the circle through all
    of its edge points, may say against a dome.
    """
    response = response_of(image)
    limit = ordered.chi2 + SETTLED
    points = edge_points(image, response)
    found = [peak.straight for peak in peaks(points, image, 2, response)]
    out = []
    everything = np.ones(len(points), dtype=bool)
    circle = (
        circle_through(points, everything, LONGEST) if len(points) > 2 and ordered.shape != RIDGE else None
    )
    if circle is not None:
        rim = Region((), NO_TERMS if circle[3] > 0 else WHOLE, (circle[3],))
        rival = _fitted(image, rim, np.array(circle[:3]), limit)
        out += [] if rival is None else [rival]
    for chosen in ((0,), (1,), (0, 1)):
        if chosen[-1] < len(found):
            sides = tuple(found[k][2] for k in chosen)
            shape = np.array([value for k in chosen for value in found[k][:2]])
            rival = _fitted(image, Region(sides, (ONE, TWO)[len(chosen) - 1][0]), shape, limit)
            if rival is not None:
                out.append(rival)
    return out


def as_wall(image: TactileImage, ordered: Ordered) -> Reading | None:
    """A narrow ridge read as a flat wall between two parallel edges; none where it is not narrow."""
    d0, gx, gy, kxx, kxy, kyy = ordered.fit.parameters[:6].tolist()
    mean, half = 0.5 * (kxx + kyy), hypot(0.5 * (kxx - kyy), kxy)
    k = mean + half
    if k <= 0.0 or abs(mean - half) > CYLINDRIC * k:
        return None
    across = 0.5 * float(np.arctan2(kxy, 0.5 * (kxx - kyy)))
    slope = float(np.cos(across)) * gx + float(np.sin(across)) * gy
    top = d0 + slope**2 / (2 * k)
    reach = BOX * sqrt(max(0.0, 2 * top / k))
    if 2 * reach > NARROW * min(image.array.size) or reach == 0.0:
        return None
    middle, angle = slope / k, across - pi / 2  # of a line whose positive offset is across
    shape = np.array([angle, middle - reach, angle, middle + reach])
    return _fitted(image, _WALL, shape, ordered.chi2 + SETTLED)


_WALL = Region((1.0, -1.0), TWO[0])


def _fitted(image: TactileImage, region: Region, shape: Floats, limit: float) -> Reading | None:
    soft = softened(image)
    fit = fit_region(soft, response_of(image), region, shape, limit=limit)
    if fit.chi2 > limit:
        return None
    if soft is not image:
        fit = on_its_skin(image, fit)
    return reading_of_region(image, fit) if fit.converged and fit.chi2 < limit else None


def _of_lines(image: TactileImage, angles: Floats, covariance: Floats, union: bool) -> tuple[str, float]:
    """Kind, and log density before touch of a face's plane and its lines."""
    n = len(angles)
    reach = hypot(*image.array.size)
    if n == 2 and abs(sin(float(angles[0] - angles[1]))) < PARALLEL:
        apart = float((angles[0] - angles[1] + pi / 2) % pi - pi / 2)
        a, b = len(covariance) - 4, len(covariance) - 2
        variance = float(covariance[a, a] + covariance[b, b] - 2 * covariance[a, b]) + ASKEW**2
        density = LEVEL - log(pi * reach * min(image.array.size))
        density -= 0.5 * apart**2 / variance + 0.5 * log(2 * pi * variance)
        return "edge" if union else "ridge", density
    return "edge" if n == 1 else "corner", LEVEL - n * log(pi * reach)


def _volume(covariance: Floats) -> float:
    """Log of what a frame leaves of its unknowns, slopes (second and third) held by their prior."""
    if not np.linalg.slogdet(covariance)[0] > 0:
        return -inf
    precision = np.linalg.inv(covariance)
    precision[[1, 2], [1, 2]] += SLOPE**-2
    return -0.5 * float(np.linalg.slogdet(precision / (2 * pi))[1])
