"""A curved contact that ends in edges across its ridge: the flank of a cylinder or cone between its rims.

A paraboloid's own outline is an ellipse.  Where a ridge runs into an edge its outline is cut square, the fitted
paraboloid bends down along the ridge to follow, and its top comes out too high, by 0.03 to 0.05 mm where the pad
lies across a rim.  So where the paraboloid does not explain a frame, it is fitted again without curvature along
the ridge, cut by a line across it at one end of what is felt, at the other, and at both (our derivation).

A flank that ends under the pad is also felt nearly as a narrow flat strip between three or more edges, which says
far more than is known of it: four points of a plane, up to 0.06 mm too deep on a cylinder of radius 20 mm.
`as_flank` reads the strip's long edges as the ridge's own ends of contact.
"""

from collections.abc import Sequence
from itertools import combinations
from math import atan2

import numpy as np

from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.line import Line
from exploration.sensing.surfaces.footprint import fit_footprint
from exploration.sensing.surfaces.local_surface import LocalSurface, surface_of
from primitives.arrays import Floats

DOUBTED = 1.5  # chi2 per degree of freedom from which a curved surface is looked at again
RIDGE = 0.6  # the lesser curvature is at most this share of the greater
WORTH = 25.0  # [chi2] that each end must gain
ALONG = 0.5  # [sine of the angle] between the long edges of a strip
BOX = 0.8  # of a parabola's half width: half the width of a box that is felt like it
INSET = 0.5  # [mm] from the outermost touched taxel at which an end is looked for


def cut_at_ends(image: TactileImage, surface: LocalSurface) -> LocalSurface:
    """The surface cut at the ends of its ridge, where that explains the frame; else the surface itself."""
    if surface.chi2 < DOUBTED * surface.dof or not surface.curved:
        return surface
    values, vectors = surface.principal
    ridge = vectors[1, :2] / np.linalg.norm(vectors[1, :2])
    if values[0] <= 0.0 or values[1] > RIDGE * values[0]:
        return surface
    x, y = np.meshgrid(image.array.x, image.array.y)
    along = np.stack([x[surface.mask], y[surface.mask]], axis=1) @ ridge
    start = _straightened(surface, ridge)
    angle = atan2(-ridge[0], ridge[1])  # of a line whose normal is the ridge
    low, high = (float(along.min()) + INSET, 1.0), (float(along.max()) - INSET, -1.0)
    best, least = surface, surface.chi2
    for ends in ((low,), (high,), (low, high)):
        cuts = np.array([value for offset, _ in ends for value in (angle, offset)])
        fit = fit_footprint(image, np.concatenate([start, cuts]), np.array([side for _, side in ends]))
        price = WORTH * len(ends) * max(1.0, fit.chi2 / max(1, fit.dof))
        if fit.converged and fit.chi2 + price < least:
            best, least = surface_of(image, surface.mask, fit, True), fit.chi2 + price
    return best


def as_flank(
    image: TactileImage, smooth: LocalSurface, lines: Sequence[Line], arcs: int = 0
) -> LocalSurface | None:
    """A strip between three or more lines and arcs as a ridge that some of them cut; none where it is no strip.

    Of two lines that face each other either both end the ridge, or both are where its contact ends by itself.
    """
    pairs = [
        (abs(float(np.sin(a.angle - b.angle))), i, j)
        for (i, a), (j, b) in combinations(enumerate(lines), 2)
        if float(a.inward @ b.inward) < 0.0
    ]
    if len(lines) + arcs < 3 or not pairs or min(pairs)[0] > ALONG:
        return None
    _, i, j = min(pairs)
    pair, others = (lines[i], lines[j]), [line for k, line in enumerate(lines) if k not in (i, j)]
    across = pair[0].inward - pair[1].inward
    found = [
        cut_at_ends(image, smooth),
        _cut_by(image, smooth, _straightened(smooth, across / np.linalg.norm(across)), pair),
    ]
    if others:
        found.append(_cut_by(image, smooth, _rounded(*pair), others))
    best = min(found, key=lambda surface: surface.chi2)
    return None if best is smooth else best


def _cut_by(image: TactileImage, smooth: LocalSurface, start: Floats, ends: Sequence[Line]) -> LocalSurface:
    """The paraboloid from `start` (6,) that lines cut; the smooth surface where its fit fails."""
    cuts = np.array([value for line in ends for value in (line.angle, line.offset)])
    sides = np.array([float(line.material_side) for line in ends])
    fit = fit_footprint(image, np.concatenate([start, cuts]), sides)
    return surface_of(image, smooth.mask, fit, True) if fit.converged else smooth


def _rounded(first: Line, second: Line) -> Floats:
    """Coefficients (6,) of the ridge whose contact holds as much as a strip between two lines.

    A parabola of height t and half width w holds as much as a box of width 2 b w and depth t (2/3) / b.
    """
    along = first.direction + np.copysign(1.0, first.direction @ second.direction) * second.direction
    across = np.array([-along[1], along[0]]) / np.linalg.norm(along)
    u, v = (float(across @ (line.start + line.end)) / 2 for line in (first, second))
    top = 1.5 * BOX * 0.5 * (first.plateau + second.plateau)
    k, middle = 2.0 * top * (2.0 * BOX / (u - v)) ** 2, 0.5 * (u + v)
    gx, gy = k * middle * across
    return np.array([top - 0.5 * k * middle**2, gx, gy, *(k * across[[0, 0, 1]] * across[[0, 1, 1]])])


def _straightened(surface: LocalSurface, ridge: Floats) -> Floats:
    """Coefficients (6,) that agree at the contact point and have no slope or curvature along the ridge."""
    c, at = surface.coefficients, surface.point[:2]
    hessian = np.array([[c[3], c[4]], [c[4], c[5]]])
    across = np.eye(2) - np.outer(ridge, ridge)
    bent = across @ hessian @ across
    gradient = across @ (c[1:3] - hessian @ at) + bent @ at
    level = -surface.point[2] - gradient @ at + 0.5 * at @ bent @ at
    return np.array([level, *gradient, bent[0, 0], bent[0, 1], bent[1, 1]])
