"""The flank of a cylinder or cone, or the crest of a ring, where a paraboloid does not explain what is felt.

A paraboloid's own outline is an ellipse.  Where a ridge runs into an edge its outline is cut square, the fitted
paraboloid bends down along the ridge to follow, and its top comes out too high, by 0.03 to 0.05 mm where the pad
lies across a rim; and where the ridge sharpens toward an apex the outline is a wedge.

Both are also felt nearly as a narrow flat strip between two or more edges, which says far more than is known of
them: four points of a plane, up to 0.07 mm too deep on a flank of radius 10 to 20 mm.  So wherever long edges face
each other the strip is tried against a flank (`cone_flank`) whose contact they end.
"""

from collections.abc import Sequence
from itertools import combinations
from math import atan2, cos, log, sin, sqrt
from typing import NamedTuple

import numpy as np

from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.line import Line
from exploration.sensing.surfaces.anatomy import SIGNIFICANT
from exploration.sensing.surfaces.bent_ridge import TURNING, deepest, dome, fit_bent_ridge
from exploration.sensing.surfaces.cone_flank import fit_cone_flank, paraboloid
from exploration.sensing.surfaces.footprint import Footprint
from exploration.sensing.surfaces.local_surface import LocalSurface, surface_of
from primitives.arrays import Floats

DOUBTED = 1.5  # chi2 per degree of freedom from which a curved surface is looked at again
EXPLAINED = 3.0  # [standard deviations of chi2] within which no further end is looked for
RIDGE = 0.6  # the lesser curvature is at most this share of the greater
WORTH = 25.0  # [chi2] that each end must gain
ALONG = 0.5  # [sine of the angle] between the long edges of a strip
BOX = 0.8  # of a parabola's half width: half the width of a box that is felt like it
LEAST_BENT = 0.005  # [1/mm] curvature that the fit starts from
SAME = 0.3  # [sine of the angle] up to which a strip and a smooth surface have one ridge
INSET = 0.5  # [mm] from the outermost touched taxel at which an end is looked for


def crest_of(image: TactileImage, smooth: LocalSurface) -> tuple[Footprint, float] | None:
    """The dome that a ridge which turns has in the middle of the contact, and log evidence of its turn; none where
    a ridge that does not turn explains the frame nearly as well, or this does not.
    """
    ridge = _ridge(smooth)
    if ridge is None:
        return None
    d0, slope, k, angle, _, middle = _top(smooth, ridge)
    bent = fit_bent_ridge(image, np.array([d0, slope, k, angle, 0.0, middle, 0.0]))
    if bent.chi2 + WORTH > smooth.chi2:
        return None
    bent = fit_bent_ridge(image, bent.parameters, fine=True)
    if not _explains(bent):
        return None
    along = _along(image, smooth, bent.parameters[3])
    at = float(np.clip(deepest(bent, float(along.mean())), along.min(), along.max()))
    return dome(bent, at), log(sqrt(float(bent.covariance[6, 6])) / TURNING)


class End(NamedTuple):
    """An edge across a ruling, as `cone_flank` has it."""

    offset: float  # [mm]
    turn: float  # [rad]
    side: float  # +1 where the material lies towards greater u


def flank_of(
    image: TactileImage, smooth: LocalSurface, limit: float, lines: Sequence[Line] = (), arcs: int = 0
) -> LocalSurface | None:
    """The likeliest flank, cut at its ends, with chi2 below `limit`; none where nothing is felt that may be one.

    Of two lines that face each other either both end the ridge, or both are where its contact ends by itself.
    """
    pair, found = _facing(lines), []
    if pair is not None:
        start = _between(*pair)
        ends = [_end(line, start[3]) for line in lines if line is not pair[0] and line is not pair[1]]
        found.append(_fitted(image, smooth, start, ends, limit, bool(ends) or arcs > 0))
    ridge = _ridge(smooth)
    if pair is not None and ridge is not None and abs(sin(start[3] - atan2(ridge[1], ridge[0]))) < SAME:
        ridge = None
    if ridge is not None and not any(_explains(flank) for flank in found):
        found.append(_fitted(image, smooth, _top(smooth, ridge), [], limit, True))
    if pair is not None and not any(_explains(flank) for flank in found):
        across = pair[0].inward - pair[1].inward
        start = _top(smooth, across / np.linalg.norm(across))
        found.append(_fitted(image, smooth, start, [_end(line, start[3]) for line in pair], limit, False))
    found = [flank for flank in found if flank.converged and flank.dof > 0 and flank.chi2 < limit]
    found = [flank for flank in found if _bent(flank)]
    if not found:
        return None
    best = min(found, key=lambda flank: flank.chi2)
    middle = float(_along(image, smooth, best.parameters[3]).mean())
    return surface_of(image, smooth.mask, paraboloid(best, middle), True)


def _fitted(
    image: TactileImage, smooth: LocalSurface, start: Floats, ends: list[End], limit: float, more: bool
) -> Footprint:
    """The flank with these ends, and with those where the contact ends, if `more` and they pay."""
    best = _with_ends(image, start, ends, np.inf if more else limit)
    if not more or _explains(best):
        return best
    along = _along(image, smooth, start[3])
    low, high = End(float(along.min()) + INSET, 0.0, 1.0), End(float(along.max()) - INSET, 0.0, -1.0)
    known = {end.side for end in ends}
    free = [end for end in (low, high) if end.side not in known]
    start = best.parameters[: len(start)] if best.converged else start
    least = best.chi2
    for added in [free] if len(free) == 1 else [[low], [high], free] if free else []:
        flank = _with_ends(image, start, [*ends, *added], min(limit, least))
        price = WORTH * len(added) * max(1.0, flank.chi2 / max(1, flank.dof))
        if flank.converged and flank.chi2 + price < least:
            best, least = flank, flank.chi2 + price
    return best


def _with_ends(image: TactileImage, start: Floats, ends: Sequence[End], limit: float) -> Footprint:
    cuts = [value for end in ends for value in (end.offset, end.turn)]
    return fit_cone_flank(image, np.array([*start, *cuts]), np.array([end.side for end in ends]), limit)


def _bent(flank: Footprint) -> bool:
    """Whether it is surely round: a flat face is a flank too, of no curvature."""
    return bool(flank.parameters[2] > SIGNIFICANT * np.sqrt(flank.covariance[2, 2]))


def _explains(fit: Footprint) -> bool:
    return fit.converged and fit.chi2 < fit.dof + EXPLAINED * sqrt(2 * max(0, fit.dof))


def _facing(lines: Sequence[Line]) -> tuple[Line, Line] | None:
    """The two lines with material between them that are the nearest to parallel."""
    pairs = [
        (abs(sin(a.angle - b.angle)), k, (a, b))
        for k, (a, b) in enumerate(combinations(lines, 2))
        if float(a.inward @ b.inward) < 0.0
    ]
    return min(pairs)[2] if pairs and min(pairs)[0] <= ALONG else None


def _ridge(smooth: LocalSurface) -> Floats | None:
    """Unit vector (2,) along a smooth surface's ridge; none where it has none."""
    values, vectors = smooth.principal
    if not smooth.curved or values[0] <= 0.0 or values[1] > RIDGE * values[0]:
        return None
    ridge: Floats = vectors[1, :2] / np.linalg.norm(vectors[1, :2])
    return ridge


def _along(image: TactileImage, smooth: LocalSurface, angle: float) -> Floats:
    """(n,) [mm] along the ruling, of what is touched."""
    rows, columns = np.nonzero(smooth.mask)
    places: Floats = cos(angle) * image.array.x[columns] + sin(angle) * image.array.y[rows]
    return places


def _between(first: Line, second: Line) -> Floats:
    """The flank whose contact holds as much as a strip between two lines.

    A parabola of height t and half width w holds as much as a box of width 2 b w and depth t (2/3) / b.
    """
    along = first.direction + np.copysign(1.0, first.direction @ second.direction) * second.direction
    angle = atan2(along[1], along[0])
    across = np.array([-sin(angle), cos(angle)])
    u, v = (float(across @ (line.start + line.end)) / 2 for line in (first, second))
    top = 1.5 * BOX * 0.5 * (first.plateau + second.plateau)
    return np.array([top, 0.0, 2.0 * top * (2.0 * BOX / (u - v)) ** 2, angle, 0.0, 0.5 * (u + v)])


def _top(smooth: LocalSurface, ridge: Floats) -> Floats:
    """The flank that agrees with a smooth surface at the contact point, without slope along the ridge."""
    x, y = across = np.array([-ridge[1], ridge[0]])
    kxx, kxy, kyy = smooth.coefficients[3:6]
    bent = max(LEAST_BENT, kxx * x * x + 2 * kxy * x * y + kyy * y * y)
    middle = float(across @ smooth.point[:2])
    return np.array([-smooth.point[2], 0.0, bent, atan2(ridge[1], ridge[0]), 0.0, middle])


def _end(line: Line, angle: float) -> End:
    """A line as an end of the ruling at `angle`."""
    cosine, sine = sin(angle - line.angle), cos(angle - line.angle)
    sign = 1.0 if cosine >= 0.0 else -1.0
    return End(sign * line.offset, atan2(sign * sine, sign * cosine), sign * line.material_side)
