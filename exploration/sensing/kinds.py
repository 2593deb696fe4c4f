"""The kind of a touch by evidence: nothing, flat, edge, ridge, corner or curved, with a probability each.

Each reading of a frame, with chi2 at its best, has evidence (Laplace; our derivation)

    log E = log prior - chi2 / 2 s + log det(2 pi C)/2 + log p,

C the covariance of its unknowns, p their density before touch, and s = max(1, chi2 per degree of freedom of the
best reading), so that what no reading explains is not held for any.  Before touch depth is even over 2 mm; slopes
are N(0, 0.1), but where the surface is curved its pole is even over the pad; curvatures are N(0, 0.1 / mm) by
`order`; lines are even over the pad in angle and offset, the two of a wall parallel to `ASKEW`; an arc's radius is
even in log.  "Nothing" has no unknowns.

One line or arc is an edge; two nearly parallel lines are a ridge, any others a corner; a smooth surface sharper
than `SHARP` is a ridge or a corner as far as its curvature is known (our choice).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot, inf, log, pi, sin, sqrt

import numpy as np
from scipy.special import ndtr

from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.edges import edge_points
from exploration.sensing.lines.hough import DEFAULT, candidates
from exploration.sensing.lines.line import Line
from exploration.sensing.lines.outline import Outline
from exploration.sensing.response import response_of
from exploration.sensing.surfaces.footprint import PLANE as FLAT_CUT
from exploration.sensing.surfaces.footprint import Footprint, fit_footprint
from exploration.sensing.surfaces.local_surface import LocalSurface
from exploration.sensing.surfaces.order import Ordered
from exploration.sensing.surfaces.smooth_fit import RIDGE, SmoothContact
from primitives.arrays import Floats, frozen

KINDS = ("nothing", "flat", "edge", "ridge", "corner", "curved")
SHARP = 0.3  # [1/mm] curvature from which a smooth contact is a ridge or a corner
PARALLEL = 0.3  # [sine of the angle] between the two edges of a ridge
LEAST = 0.002  # probability left to every kind
PRIOR = {"nothing": 0.1, "smooth": 0.4, "edge": 0.2, "ridge": 0.15, "corner": 0.15}
SLOPE = 0.1  # standard deviation of a pad's slope on a face before touch
TURNED = 0.25  # sqrt(2 pi) of that: what a density of 1 / TURNED is even over
BENT_FACE = 0.2  # probability that a face with edges under the pad is curved
NARROW = 0.7  # [pad's short side] a ridge narrower than this may be a wall with two edges
CERTAIN = 1.0 - LEAST  # probability of a plane that nothing rivals, from which no other kind is weighed
SETTLED = 30.0  # [chi2] by which a reading behind the best is out of the question
ASKEW = 0.01  # [rad] by which the edges of a wall are not parallel


@dataclass(frozen=True)
class Reading:
    """One way to understand a frame."""

    kind: str
    chi2: float
    dof: int
    volume: float  # log of what is left of the range of its lines


def reading_of_lines(image: TactileImage, fit: Footprint) -> Reading:
    """What lines cut out of a plane or dome say."""
    angles = fit.parameters[6::2]
    n = len(angles)
    bent = bool(fit.covariance[3:6, 3:6].any())
    free = [0, 1, 2, *([3, 4, 5] if bent else []), *range(6, 6 + 2 * n)]
    covariance = fit.covariance[np.ix_(free, free)]
    density = _LEVEL - (3 * log(TURNED) - log(BENT_FACE) if bent else 0.0)
    reach = hypot(*image.array.size)
    kind = "edge" if n == 1 else "corner"
    if n == 2 and abs(sin(float(angles[0] - angles[1]))) < PARALLEL:
        kind = "ridge"
        apart = float((angles[0] - angles[1] + pi / 2) % pi - pi / 2)
        a, b = len(free) - 4, len(free) - 2
        variance = float(covariance[a, a] + covariance[b, b] - 2 * covariance[a, b]) + ASKEW**2
        density -= log(pi * reach * min(image.array.size))
        density -= 0.5 * apart**2 / variance + 0.5 * log(2 * pi * variance)
    else:
        density -= n * log(pi * reach)
    return Reading(kind, fit.chi2, fit.dof, density + _volume(covariance))


def _volume(covariance: Floats) -> float:
    """Log of what a frame leaves of its unknowns, slopes (second and third) held by their prior."""
    if not np.linalg.slogdet(covariance)[0] > 0:
        return -inf
    precision = np.linalg.inv(covariance)
    precision[[1, 2], [1, 2]] += SLOPE**-2
    return -0.5 * float(np.linalg.slogdet(precision / (2 * pi))[1])


def reading_of_outline(image: TactileImage, outline: Outline, ordered: Ordered) -> Reading:
    """What an outline with arcs says; its face is taken to be known as well as a smooth one."""
    reach = hypot(*image.array.size)
    n, m = len(outline.lines), len(outline.arcs)
    volume = _LEVEL + ordered.volume - n * log(pi * reach)
    for arc in outline.arcs:
        volume -= 2 * log(reach) + log(max(arc.radius, 1.0) * log(100.0))
    for covariance in (
        *(line.covariance for line in outline.lines),
        *(arc.covariance for arc in outline.arcs),
    ):
        volume += 0.5 * float(np.linalg.slogdet(2 * pi * covariance)[1])
    return Reading("edge" if n + m == 1 else "corner", outline.chi2, outline.dof, volume)


def fewer(image: TactileImage, lines: Sequence[Line], fit: Footprint) -> list[Reading]:
    """The same with one line less, if there are several."""
    out = []
    for k in range(len(lines) if len(lines) > 1 else 0):
        left = [line for i, line in enumerate(lines) if i != k]
        start = np.concatenate(
            [fit.parameters[:3], np.zeros(3), *([line.angle, line.offset] for line in left)]
        )
        sides = np.array([line.material_side for line in left], dtype=float)
        out.append(reading_of_lines(image, fit_footprint(image, start, sides, shape=FLAT_CUT, steps=8)))
    return out


def rivals(image: TactileImage, level: float, limit: float) -> list[Reading]:
    """What the two strongest straight rims of a frame, as an edge each and as a corner, may say against a dome."""
    response = response_of(image)
    found = candidates(edge_points(image, response), image, 2, response, DEFAULT)
    out = []
    for chosen in ((0,), (1,), (0, 1)):
        if chosen[-1] < len(found):
            cuts = [value for k in chosen for value in found[k][:2]]
            start = np.array([level, 0.0, 0.0, 0.0, 0.0, 0.0, *cuts])
            sides = np.array([float(found[k][2]) for k in chosen])
            fit = fit_footprint(image, start, sides, shape=FLAT_CUT, limit=limit)
            if fit.converged and fit.chi2 < limit:
                out.append(reading_of_lines(image, fit))
    return out


def as_wall(image: TactileImage, ordered: Ordered) -> Reading | None:
    """A narrow ridge read as a flat wall between two parallel edges; none where it is not narrow."""
    if ordered.shape != RIDGE:
        return None
    p = ordered.fit.parameters
    k = float(p[3] + p[5])
    if k <= 0.0:
        return None
    across = 0.5 * float(np.arctan2(p[4], 0.5 * (p[3] - p[5])))
    normal = np.array([np.cos(across), np.sin(across)])
    slope = float(normal @ p[1:3])
    top = float(p[0]) + slope**2 / (2 * k)
    half = 0.8 * sqrt(max(0.0, 2 * top / k))  # of a box that holds what the parabola does
    if 2 * half > NARROW * min(image.array.size) or half == 0.0:
        return None
    middle = slope / k
    along = p[1:3] - slope * normal
    angle = across - pi / 2  # of a line whose positive offset is along `normal`
    start = np.array([0.8 * top, *along, 0.0, 0.0, 0.0, angle, middle - half, angle, middle + half])
    fit = fit_footprint(image, start, _WALL, shape=FLAT_CUT, steps=10, limit=ordered.chi2 + SETTLED)
    return reading_of_lines(image, fit) if fit.converged else None


_WALL = frozen([1.0, -1.0])
_LEVEL = -log(2.0) - 2 * log(TURNED)  # log density of a depth and two slopes


def probabilities(
    contact: SmoothContact, ordered: Ordered, smooth: LocalSurface, readings: Sequence[Reading]
) -> dict[str, float]:
    """(`KINDS`) of a frame whose smooth reading is `ordered`, beside those with lines."""
    if not readings and ordered.probability[0] > CERTAIN:
        return only("flat")
    empty = float(np.sum((contact.depth * contact.precision) ** 2))
    best = min([(smooth.chi2, smooth.dof), *((r.chi2, r.dof) for r in readings)])
    scale = max(1.0, best[0] / max(1, best[1]))
    logs = dict.fromkeys(KINDS, -inf)
    sharp, both = sharpness(smooth)
    values = np.abs(smooth.principal[0])
    size = hypot(contact.x[-1] - contact.x[0], contact.y[-1] - contact.y[0])
    whole = -0.5 * ordered.chi2 / scale + log(PRIOR["smooth"]) + ordered.evidence + ordered.volume
    poles = -log(2.0) - sum(log(max(TURNED, float(k) * size)) for k in values)
    odds_of = np.maximum(ordered.probability, 1e-300) * np.exp(np.array([_LEVEL, poles, poles, poles]))
    whole += log(odds_of.sum())
    flat = float(odds_of[0] / odds_of.sum())
    for kind, share in (
        ("flat", flat),
        ("curved", (1.0 - flat) * (1.0 - sharp)),
        ("ridge", (1.0 - flat) * sharp * (1.0 - both)),
        ("corner", (1.0 - flat) * sharp * both),
    ):
        if share > 0.0:
            logs[kind] = whole + log(share)
    logs["nothing"] = -0.5 * empty / scale + log(PRIOR["nothing"])
    for reading in readings:
        value = -0.5 * reading.chi2 / scale + reading.volume + log(PRIOR[reading.kind])
        logs[reading.kind] = float(np.logaddexp(logs[reading.kind], value))
    top = max(logs.values())
    odds: Floats = np.exp(np.array([logs[kind] - top for kind in KINDS]))
    share_of = LEAST + (1.0 - LEAST * len(KINDS)) * odds / odds.sum()
    return dict(zip(KINDS, share_of.tolist(), strict=True))


def only(kind: str) -> dict[str, float]:
    """All that is left to a kind which nothing rivals."""
    return {name: 1.0 - LEAST * (len(KINDS) - 1) if name == kind else LEAST for name in KINDS}


def sharpness(surface: LocalSurface) -> tuple[float, float]:
    """Probabilities that the greater, and the lesser, principal curvature is sharp."""
    if not surface.curved:
        return 0.0, 0.0
    sigma = sqrt(float(surface.curvature_covariance[[0, 2], [0, 2]].max())) + 1e-6
    greatest, least = surface.principal[0]
    return float(ndtr((greatest - SHARP) / sigma)), float(ndtr((least - SHARP / 2) / sigma))
