"""The outline of the face under the pad: lines and arcs that compete by likelihood for one frame.

Every hypothesis is a `Region`, fitted to all taxels at once in closed form (`region_fit`): one line; an arc,
of which a line is the limit; two and three lines, joined in all ways; a rim inside a rim; holes in what was found.
Each line or arc more must be worth it by its evidence, and a hypothesis that explains the frame ends the search.
What a smooth surface explains as well, by all the evidence (`outline_evidence`), has no outline: "nothing" is an
answer.
"""

from dataclasses import dataclass, field
from math import hypot, inf, sqrt

import numpy as np

from exploration.sensing.contact_mask import usable
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.arc import Arc
from exploration.sensing.lines.edges import edge_points
from exploration.sensing.lines.estimate_bias import bias_of
from exploration.sensing.lines.line import Line, normalized
from exploration.sensing.lines.line_fit import softened
from exploration.sensing.lines.outline_evidence import is_wall, log_odds, log_over, log_weight
from exploration.sensing.lines.outline_search import Evidence, SearchConfig, search
from exploration.sensing.lines.parallel import made_parallel
from exploration.sensing.lines.peaks import peaks
from exploration.sensing.lines.region import NO_TERMS, Region
from exploration.sensing.lines.region_fit import LEAST_RADIUS, LEVEL, RegionFit, fit_region
from exploration.sensing.lines.seen import seen_of_disc, seen_of_line
from exploration.sensing.lines.short_skin import on_its_skin
from exploration.sensing.response import Response, response_of
from exploration.sensing.surfaces.footprint import Footprint
from exploration.sensing.surfaces.smooth_fit import SmoothContact, fit_dome, smooth_contact
from primitives.arrays import Floats, frozen


@dataclass(frozen=True)
class OutlineConfig:
    """What counts as found."""

    odds: float = 2.94  # [log] of an outline against all smooth surfaces: 19 to 1
    corner_odds: float = 1.5  # [log] of several lines that are no wall, the same: few surfaces resemble those
    arc_odds: float = 0.0  # [log] of one arc, the same: what is likelier
    line_odds: float = inf  # [log] of one line that fits no better, the same
    straight_odds: float = inf  # [log] of lines against an outline with arcs, in whose stead they are said
    narrow: bool = True  # also of a wall or pin that may as well be a cylinder or ball narrower than the pad
    strength: float = 5.0  # [sigma] of the step's height
    length: float = 1.6  # [taxels] of a line that is seen
    search: SearchConfig = field(default_factory=SearchConfig)


@dataclass(frozen=True)
class Outline:
    """Edges of one frame; false where there are none."""

    lines: tuple[Line, ...] = ()
    arcs: tuple[Arc, ...] = ()
    chi2: float = 0.0
    dof: int = 0
    over_smooth: float = 0.0  # [chi2] by which this is likelier than the best smooth surface
    fit: RegionFit | None = None  # behind the lines and arcs, before any are made parallel

    def __bool__(self) -> bool:
        return bool(self.lines or self.arcs)

    def explains(self, deviations: float) -> bool:
        """Whether what is said here, were it nothing, leaves no more than so many deviations of chi2."""
        return self.dof > 0 and self.chi2 < self.dof + deviations * sqrt(2 * self.dof)


NOTHING = Outline()
BOSS = Region((), NO_TERMS, (1.0,))
DEFAULT = OutlineConfig()
LIKELIEST = OutlineConfig(line_odds=-2.94, straight_odds=-5.0)  # lines, unless another is clearly likelier
UNMISTAKABLE = OutlineConfig(narrow=False, corner_odds=2.94)  # nothing that might as well be a smooth surface


def find_outline(
    image: TactileImage,
    max_lines: int = 3,
    response: Response | None = None,
    config: OutlineConfig | None = None,
    smooth: Footprint | None = None,
) -> Outline:
    """Straight edges and arcs of a frame, each kind strongest first; `smooth` is its dome, if that is fitted."""
    if not usable(image):
        return NOTHING
    config = config or DEFAULT
    response = response_of(image, response)
    points = edge_points(image, response)
    soft = softened(image)
    voted = tuple(peak.straight for peak in peaks(points, image, max_lines, response))
    found = search(Evidence(soft, response, points, voted, max_lines), config.search)
    if found is None:
        return NOTHING
    best, straight = found
    if best.region == Region():
        return Outline((), (), best.chi2, best.dof)
    contact = smooth_contact(image)
    if not contact:
        return NOTHING
    smooth = smooth or fit_dome(contact)
    size = hypot(*image.array.size)
    if best.region.signs and straight.region.sides and not straight.region.signs:
        odds = log_over(straight, best) + log_weight(straight, size) - log_weight(best, size)
        if odds > config.straight_odds and _likely(image, straight, contact, smooth, config):
            best = straight
    gain = smooth.chi2 - best.chi2 if smooth.converged else inf
    if not _likely(image, best, contact, smooth, config):
        return Outline((), (), smooth.chi2, smooth.dof, gain)
    if best.region == BOSS:
        best = _leveled(soft, response, best)
    if soft is not image:
        best = on_its_skin(image, best)
    return outline_of(image, best, gain, config, response)


def _leveled(image: TactileImage, response: Response, fit: RegionFit) -> RegionFit:
    """A boss alone under the pad, as one that the pad was leveled on sees it.

    A disc hardly wider than the blur does not show its slope.  Left open, slopes that are noise narrow what is
    seen by (g R^2 / 4 h)^2 a direction, and R grows by about var(g) R^3 / 8 h^2 to make up for it, as much as its
    own error where R is 3 mm (our derivation).
    """
    d0, gx, gy, x, y, radius = fit.parameters.tolist()
    arm = radius**2 / (4.0 * max(1e-3, d0 + gx * x + gy * y))
    start = (x + gx * arm, y + gy * arm, radius)  # what is felt has its middle there
    level = fit_region(image, response, fit.region, start, slope=LEVEL)
    return level if level.converged else fit


def _likely(
    image: TactileImage, best: RegionFit, contact: SmoothContact, smooth: Footprint, config: OutlineConfig
) -> bool:
    """Whether an outline is likely enough beside smooth surfaces; a lone line is, too, where it fits better."""
    kind = len(best.region.sides), len(best.region.signs)
    if kind == (1, 0) and (not smooth.converged or smooth.chi2 >= best.chi2):
        return True
    corner = config.odds if is_wall(best) else config.corner_odds
    asked = {
        (1, 0): config.line_odds,
        (2, 0): corner,
        (3, 0): corner,
        (0, 1): config.arc_odds,
    }.get(kind, config.odds)
    return asked < inf and log_odds(image, best, contact, smooth, config.narrow) > asked


def outline_of(
    image: TactileImage,
    fit: RegionFit,
    gain: float = 0.0,
    config: OutlineConfig = DEFAULT,
    response: Response | None = None,
) -> Outline:
    """Lines and arcs of a fit, over what the pad sees of them; sides that may be parallel are."""
    lines, arcs = [], []
    free, fit = fit, made_parallel(fit)
    p, covariance = fit.parameters, fit.covariance * fit.inflation
    size = image.array.size
    n = len(fit.region.sides)
    bias = bias_of(image, response_of(image, response), free) if fit.region.signs else np.zeros(len(p))
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
        line = Line(angle, offset, frozen(shared), high - low, ends[0], ends[1], strength, turned, height)
        if strength > config.strength and line.length > config.length * min(image.array.pitch):
            lines.append(line)
    for k, sign in enumerate(fit.region.signs):
        rows = slice(3 + 2 * n + 3 * k, 6 + 2 * n + 3 * k)
        turn, step = seen_of_disc(fit.region, p, p[rows], size)
        if not len(turn):
            continue
        rim = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        height, strength = _height(p, covariance, (p[rows][:2] + p[rows][2] * rim).mean(axis=0))
        shared = frozen(covariance[rows, rows])
        disc = p[rows] - bias[rows] / (1.0 + max(0.0, float(bias[rows][2] / p[rows][2])))
        if strength > config.strength:
            arc = frozen(disc[:2]), max(LEAST_RADIUS, float(disc[2])), shared, sign > 0
            arcs.append(Arc(*arc, step * len(turn), strength, height))
    lines.sort(key=lambda line: -line.strength)
    arcs.sort(key=lambda arc: -arc.strength)
    return Outline(tuple(lines), tuple(arcs), fit.chi2, fit.dof, gain, free)


def _height(p: Floats, covariance: Floats, at: Floats) -> tuple[float, float]:
    """Depth of the face [mm] at a point, and the same in standard deviations, its outline being as it is.

    A narrow face's height and width are known only together; that the face is there may be sure all the same.
    """
    m = np.array([1.0, at[0], at[1]])
    height = float(m @ p[:3])
    shape = covariance[:3, 3:] @ np.linalg.pinv(covariance[3:, 3:], 1e-12, True) @ covariance[3:, :3]
    return height, height / sqrt(max(1e-18, float(m @ (covariance[:3, :3] - shape) @ m)))
