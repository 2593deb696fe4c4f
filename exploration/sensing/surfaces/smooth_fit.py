"""The least-squares smooth contact of one frame, as a plane, a ridge, a ball or a dome of any two curvatures.

All four are one forward model (`pressed_field`, no lines), its curvatures held to a shape (`smooth_shapes`), and
fitted in that shape's unknowns (`smooth_steps`).

The fit starts from a paraboloid through the touched taxels.  Where that does not explain the frame it starts again
from the best plane, and from domes as high as what is felt and twice as high, for contacts that the blur hides.
"""

from dataclasses import dataclass, replace

import numba
import numpy as np

from exploration.sensing.contact_mask import repaired, touched, usable
from exploration.sensing.frame import TactileImage
from exploration.sensing.response import rubber
from exploration.sensing.surfaces.footprint import CURVATURE, Footprint
from exploration.sensing.surfaces.normal_equations import HUBER
from exploration.sensing.surfaces.pressed_field import geometry
from exploration.sensing.surfaces.smooth_shapes import DOME, PLANE, UNKNOWNS, nearest
from exploration.sensing.surfaces.smooth_starts import mean_depth, round_start, start_dome
from exploration.sensing.surfaces.smooth_steps import fit_from
from primitives.arrays import Bools, Floats, frozen

STEPS = 30
MORE_STEPS = 90  # for what has not settled by then: narrow ridges far from the pad's center
ENOUGH = 3.0  # [standard deviations of chi2] within which no second start is tried
UNSETTLED = 3.0  # by which the sigma of a fit that did not settle is widened
LEAN = 0.1  # 1 sigma of the slope of a face of which nothing is known


@dataclass(frozen=True)
class SmoothContact:
    """What every smooth fit to one frame needs, prepared once; false where nothing is touched."""

    depth: Floats  # (rows, columns) [mm], 0 where dead
    precision: Floats  # (rows, columns) [1/mm] one over sigma, 0 where dead
    mask: Bools  # (rows, columns) touched
    x: Floats  # (columns,) [mm]
    y: Floats  # (rows,) [mm]
    grid: tuple[Floats, Floats, Floats, Floats]
    scale: float  # [mm^2] variance of the blur, which no contact's place is known better than

    def __bool__(self) -> bool:
        return bool(self.mask.any())


def smooth_contact(image: TactileImage, mask: Bools | None = None) -> SmoothContact | None:
    """The taxels of a frame that can be read; none where it cannot."""
    if not usable(image):
        return None
    array = image.array
    if mask is None:
        width = rubber(image.spread, array.pitch).mean_width
        mask = touched(repaired(image.depth, image.sigma)[0], image.sigma, *array.pitch, width)
    depth, precision = _prepared(image.depth, image.sigma, image.gain_sigma)
    grid = geometry(array.rows, array.columns, array.pitch, image.spread, image.margin)
    return SmoothContact(depth, precision, frozen(mask, np.bool_), array.x, array.y, grid, image.spread**2)


def fit_dome(contact: SmoothContact) -> Footprint:
    """The best dome, from as many starts as it takes to explain the frame."""
    p, covariance, chi2, count, converged, residual = _fit_dome(
        contact.depth,
        contact.precision,
        contact.mask,
        contact.x,
        contact.y,
        *contact.grid,
        contact.scale,
        (DOME, PLANE),
        (STEPS, MORE_STEPS),
    )
    return Footprint(p, covariance, chi2, count - 6, converged, residual)


def held(contact: SmoothContact, dome: Footprint) -> Footprint:
    """What stands where no dome settles: the dome as far as it came, or a level plane, both doubted."""
    p, covariance = dome.parameters, dome.covariance * UNSETTLED**2
    finite = np.isfinite(dome.chi2) and np.isfinite(p).all() and np.isfinite(covariance).all()
    if finite and np.linalg.eigvalsh(covariance)[0] > 0.0:
        return replace(dome, covariance=covariance, converged=True)
    felt = contact.depth[contact.mask & (contact.precision > 0.0)]
    level = float(felt.mean()) if felt.size else 0.0
    residual = (contact.depth - np.where(contact.mask, level, 0.0)) * contact.precision
    size = np.abs(residual)
    chi2 = float(np.sum(np.where(size > HUBER, HUBER * (2.0 * size - HUBER), size * size)))
    variance = np.array([level * level, LEAN**2, LEAN**2, *([CURVATURE**2] * 3)]) + 1e-12
    count = int(np.count_nonzero(contact.precision))
    parameters = np.array([level, 0.0, 0.0, 0.0, 0.0, 0.0])
    return Footprint(parameters, np.diag(variance), chi2, count - 6, True, residual)


def fit_shape(contact: SmoothContact, dome: Footprint, shape: int, limit: float = np.inf) -> Footprint:
    """The best PLANE, RIDGE or BALL, from the one nearest to a fitted dome by the dome's own covariance.

    A shape that will not come below `limit` of chi2 is given up.
    """
    start = nearest(dome.parameters, dome.covariance, shape)
    p, covariance, chi2, count, converged, residual = fit_from(
        contact.depth, contact.precision, *contact.grid, start, shape, STEPS, limit
    )
    return Footprint(p, covariance, chi2, count - UNKNOWNS[shape], converged, residual)


@numba.njit(cache=True, error_model="numpy")
def _prepared(depth: Floats, sigma: Floats, gain_sigma: float) -> tuple[Floats, Floats]:
    """Depth and precision; a gain's share of sigma goes by the mean depth of 3 x 3 taxels.

    Going by the taxel's own reading, what reads low weighs more: a bias of 2 gain_sigma^2, several sigma of what a
    whole pad knows of a plane's depth (our derivation).
    """
    rows, columns = depth.shape
    felt, precision = np.zeros(depth.shape), np.zeros(depth.shape)
    for i in range(rows):
        for j in range(columns):
            if sigma[i, j] == np.inf:
                continue
            felt[i, j], precision[i, j] = depth[i, j], 1.0 / sigma[i, j]
            if gain_sigma > 0.0:
                total, count = 0.0, 0
                for a in range(max(0, i - 1), min(rows, i + 2)):
                    for b in range(max(0, j - 1), min(columns, j + 2)):
                        if sigma[a, b] != np.inf:
                            total += depth[a, b]
                            count += 1
                own, near = gain_sigma * max(0.0, depth[i, j]), gain_sigma * max(0.0, total / count)
                base = max(sigma[i, j] ** 2 - own * own, (0.1 * sigma[i, j]) ** 2)
                precision[i, j] = 1.0 / np.sqrt(base + near * near)
    return felt, precision


@numba.njit(cache=True, error_model="numpy")
def _fit_dome(
    depth: Floats,
    precision: Floats,
    mask: Bools,
    x: Floats,
    y: Floats,
    x_cells: Floats,
    y_cells: Floats,
    to_columns: Floats,
    to_rows: Floats,
    scale: float,
    shapes: tuple[int, int],
    steps: tuple[int, int],
) -> tuple[Floats, Floats, float, int, bool, Floats]:
    """`fit_dome`; shapes and steps come as arguments, for a kernel is compiled anew for each constant."""
    grid = (x_cells, y_cells, to_columns, to_rows)
    dome, plane = shapes
    few, more = steps
    start = start_dome(depth, precision, mask, x, y)
    best = fit_from(depth, precision, *grid, start, dome, few, np.inf)
    for attempt in range(3):
        dof = max(1, best[3] - 6)
        if best[2] < dof + ENOUGH * np.sqrt(2.0 * dof):
            break
        if attempt == 0:
            level = np.zeros(6)
            level[0] = mean_depth(depth, precision, mask)
            start = fit_from(depth, precision, *grid, level, plane, few, np.inf)[0]
        else:
            start = round_start(depth, precision, mask, x, y, scale, float(attempt))
        other = fit_from(depth, precision, *grid, start, dome, few, np.inf)
        if other[2] < best[2]:
            best = other
    if not best[4]:
        other = fit_from(depth, precision, *grid, best[0], dome, more, np.inf)
        if other[4] or other[2] < best[2]:
            best = other
    return best[0], best[1], best[2], best[3], best[4], best[5]
