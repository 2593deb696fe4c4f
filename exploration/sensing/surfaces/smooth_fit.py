"""The least-squares smooth contact of one frame, as a plane, a ridge, a ball or a dome of any two curvatures.

All four are one forward model (`pressed_field`, no lines) with coefficients d0, g and K held to

    plane K = 0,    ridge K = k e e^T with e = (cos a, sin a),    ball K = k I,    dome K free,

so a step of Gauss and Newton in a shape's own unknowns u is that of the six coefficients p carried by T = dp/du:
(T^t N T) du = T^t b, with N and b the normal equations in p (our derivation).  The Jacobian is the paraboloid's
own: what the bend to a circle changes in it is second order, and leaves the estimate without bias.

The fit starts from a paraboloid through the touched taxels.  Where that does not explain the frame it starts again
from the best plane, and from domes as high as what is felt and twice as high, for contacts that the blur hides.
"""

from dataclasses import dataclass, replace

import numba
import numpy as np

from exploration.sensing.contact_mask import repaired, touched, usable
from exploration.sensing.frame import TactileImage
from exploration.sensing.response import rubber
from exploration.sensing.surfaces.footprint import CURVATURE, GAINED, HUBER, Footprint
from exploration.sensing.surfaces.normal_equations import invert
from exploration.sensing.surfaces.pressed_field import fields_of, geometry, to_taxels
from primitives.arrays import Bools, Floats, frozen

DOME, PLANE, RIDGE, BALL = 0, 1, 2, 3
STEPS = 30
MORE_STEPS = 90  # for what has not settled by then: narrow ridges far from the pad's center
ENOUGH = 3.0  # [standard deviations of chi2] within which no second start is tried
UNSETTLED = 3.0  # by which the sigma of a fit that did not settle is widened
LEAN = 0.1  # 1 sigma of the slope of a face of which nothing is known
HOPE = 3.0  # times what a step promises, that all further steps together may gain
BLUNTED = 1.3  # by which a paraboloid through blurred taxels is too blunt (our choice of a start)
_NO_SIDES = frozen(np.empty(0))
_ALL = frozen(np.arange(6), np.int64)


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
    return SmoothContact(depth, precision, mask, array.x, array.y, grid, image.spread**2)


def fit_dome(contact: SmoothContact) -> Footprint:
    """The best dome, from as many starts as it takes to explain the frame."""
    p, covariance, chi2, count, converged, residual = _fit_dome(
        contact.depth, contact.precision, contact.mask, contact.x, contact.y, *contact.grid, contact.scale
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
    p, covariance, chi2, count, converged, residual = _fit_shape(
        contact.depth, contact.precision, *contact.grid, start, shape, STEPS, limit
    )
    return Footprint(p, covariance, chi2, count - (6, 3, 5, 4)[shape], converged, residual)


@numba.njit(cache=True, error_model="numpy")
def unexplained(residual: Floats) -> tuple[float, float]:
    """How far residuals [sigma] of a frame are from lone noise: their greatest 3 x 3 sum, and neighbors' likeness.

    Both in their own standard deviations; the greatest of some 100 blocks is about 2.6 where all is noise.
    """
    rows, columns = residual.shape
    greatest, alike, pairs = 0.0, 0.0, 0
    for i in range(rows):
        for j in range(columns):
            total, count = 0.0, 0
            for a in range(max(0, i - 1), min(rows, i + 2)):
                for b in range(max(0, j - 1), min(columns, j + 2)):
                    total += residual[a, b]
                    count += 1
            greatest = max(greatest, abs(total) / np.sqrt(count))
            if i + 1 < rows:
                alike += residual[i, j] * residual[i + 1, j]
                pairs += 1
            if j + 1 < columns:
                alike += residual[i, j] * residual[i, j + 1]
                pairs += 1
    return greatest, alike / np.sqrt(max(1, pairs))


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
def nearest(p: Floats, covariance: Floats, shape: int) -> Floats:
    """The coefficients of a shape nearest to (6,) `p` in its covariance: exact but for a ridge's angle."""
    k = np.zeros(3)
    ray = np.zeros(3)
    if shape == RIDGE:
        sign = 1.0 if p[3] + p[5] >= 0.0 else -1.0
        angle = 0.5 * np.arctan2(sign * p[4], sign * 0.5 * (p[3] - p[5]))
        c, s = np.cos(angle), np.sin(angle)
        ray[:] = (c * c, c * s, s * s)
    elif shape == BALL:
        ray[:] = (1.0, 0.0, 1.0)
    out = p.copy()
    if shape == DOME:
        return out
    ok, precision = invert(np.ascontiguousarray(covariance[3:, 3:]))
    if ok:
        weight = precision @ ray
        size = ray @ weight
        if size > 0.0:
            k = ray * ((p[3:] @ weight) / size)
        out[:3] -= np.ascontiguousarray(covariance[:3, 3:]) @ (precision @ (p[3:] - k))
    out[3:] = k
    return out


@numba.njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def _weighed(
    depth: Floats, precision: Floats, p: Floats, model: Floats, normal: Floats, rhs: Floats, residual: Floats
) -> float:
    """Normal equations of the six coefficients, and Huber's chi2; `model` becomes the weighted Jacobian."""
    n = depth.size
    felt, weight, field, left = depth.ravel(), precision.ravel(), model[0].ravel(), residual.ravel()
    jacobian = model[1:].reshape(6, n)
    chi2 = 0.0
    for i in range(n):
        r = (felt[i] - field[i]) * weight[i]
        left[i] = r
        size = abs(r)
        trust = weight[i]
        if size > HUBER:
            chi2 += HUBER * (2.0 * size - HUBER)
            share = np.sqrt(HUBER / size)
            trust *= share
            r *= share
        else:
            chi2 += r * r
        field[i] = r
        for a in range(6):
            jacobian[a, i] *= trust
    for a in range(6):
        total = 0.0
        for i in range(n):
            total += jacobian[a, i] * field[i]
        rhs[a] = total
        for b in range(a + 1):
            total = 0.0
            for i in range(n):
                total += jacobian[a, i] * jacobian[b, i]
            normal[a, b] = total
            normal[b, a] = total
    for a in range(3, 6):
        chi2 += (p[a] / CURVATURE) ** 2
        rhs[a] -= p[a] / CURVATURE**2
        normal[a, a] += 1.0 / CURVATURE**2
    return chi2


@numba.njit(cache=True, error_model="numpy")
def _tangents(p: Floats, shape: int) -> Floats:
    """(6, unknowns): how the coefficients move with the shape's own unknowns."""
    out = np.zeros((6, (6, 3, 5, 4)[shape]))
    for a in range(3):
        out[a, a] = 1.0
    if shape == DOME:
        for a in range(3, 6):
            out[a, a] = 1.0
    elif shape == BALL:
        out[3, 3] = out[5, 3] = 1.0
    elif shape == RIDGE:
        k = p[3] + p[5]
        sign = 1.0 if k >= 0.0 else -1.0
        angle = 0.5 * np.arctan2(sign * p[4], sign * 0.5 * (p[3] - p[5]))
        c, s = np.cos(angle), np.sin(angle)
        out[3, 3], out[4, 3], out[5, 3] = c * c, c * s, s * s
        out[3, 4], out[4, 4], out[5, 4] = -2.0 * k * c * s, k * (c * c - s * s), 2.0 * k * c * s
    return out


@numba.njit(cache=True, error_model="numpy")
def _moved(p: Floats, step: Floats, shape: int) -> Floats:
    """The coefficients after a step in the shape's own unknowns."""
    out = p.copy()
    out[:3] += step[:3]
    if shape == DOME:
        out[3:] += step[3:]
    elif shape == BALL:
        out[3] += step[3]
        out[5] += step[3]
    elif shape == RIDGE:
        k = p[3] + p[5]
        sign = 1.0 if k >= 0.0 else -1.0
        angle = 0.5 * np.arctan2(sign * p[4], sign * 0.5 * (p[3] - p[5])) + step[4]
        c, s = np.cos(angle), np.sin(angle)
        k += step[3]
        out[3], out[4], out[5] = k * c * c, k * c * s, k * s * s
    return out


@numba.njit(cache=True, error_model="numpy")
def _fit_shape(
    depth: Floats,
    precision: Floats,
    x: Floats,
    y: Floats,
    to_columns: Floats,
    to_rows: Floats,
    start: Floats,
    shape: int,
    steps: int,
    limit: float,
) -> tuple[Floats, Floats, float, int, bool, Floats]:
    """Levenberg's steps from `start`; coefficients, their covariance, chi2, taxels, converged, residual."""
    fields = np.zeros((2, y.shape[1], x.shape[1]))
    model = np.zeros((7, depth.shape[0], depth.shape[1]))
    normal, rhs, residual = np.zeros((6, 6)), np.zeros(6), np.zeros(depth.shape)
    trial_normal, trial_rhs, trial_residual = np.zeros((6, 6)), np.zeros(6), np.zeros(depth.shape)
    none = np.empty(0)
    unknown = np.arange(6)
    p = start.copy()
    fields_of(x, y, p, none, False, fields)
    to_taxels(fields, p, to_columns, to_rows, unknown, model)
    chi2 = _weighed(depth, precision, p, model, normal, rhs, residual)
    count = int(np.sum(precision > 0.0))
    damping = 1e-4
    converged = False
    for _ in range(steps):
        tangents = _tangents(p, shape)
        own = tangents.T @ (normal @ tangents)
        slope = tangents.T @ rhs
        for a in range(len(slope)):
            own[a, a] = own[a, a] * (1.0 + damping) + 1e-12
        ok, inverse = invert(own)
        if not ok:
            damping = max(1e-3, damping * 10.0)
            if damping > 1e6:
                break
            continue
        step = inverse @ slope
        promised = np.dot(step, slope)
        if chi2 - HOPE * promised > limit:
            break
        if promised < GAINED and damping < 1.0:
            p = _moved(p, step, shape)
            converged = True
            break
        trial = _moved(p, step, shape)
        fields_of(x, y, trial, none, False, fields)
        to_taxels(fields, trial, to_columns, to_rows, unknown, model)
        new = _weighed(depth, precision, trial, model, trial_normal, trial_rhs, trial_residual)
        if new < chi2:
            gained = chi2 - new
            p, chi2 = trial, new
            normal, trial_normal = trial_normal, normal
            rhs, trial_rhs = trial_rhs, rhs
            residual, trial_residual = trial_residual, residual
            damping = damping * 0.1 if damping > 1e-6 else 0.0
            if gained < GAINED * max(1.0, chi2 / count):
                converged = True
                break
        else:
            if promised < GAINED * max(1.0, chi2 / count):
                converged = True
                break
            damping = max(1e-3, damping * 10.0)
            if damping > 1e8:
                break
    tangents = _tangents(p, shape)
    ok, inverse = invert(tangents.T @ (normal @ tangents))
    covariance = tangents @ inverse @ tangents.T if ok else np.zeros((6, 6))
    return p, covariance, chi2, count, converged and ok, residual


@numba.njit(cache=True, error_model="numpy")
def start_dome(depth: Floats, precision: Floats, mask: Bools, x: Floats, y: Floats) -> Floats:
    """A paraboloid through the touched taxels by least squares; a level plane where they are too few."""
    normal, rhs, row = np.zeros((6, 6)), np.zeros(6), np.empty(6)
    count, total = 0, 0.0
    for i in range(len(y)):
        for j in range(len(x)):
            if mask[i, j] and precision[i, j] > 0.0:
                row[:] = (1.0, x[j], y[i], -0.5 * x[j] * x[j], -x[j] * y[i], -0.5 * y[i] * y[i])
                count += 1
                total += depth[i, j]
                for a in range(6):
                    rhs[a] += row[a] * depth[i, j]
                    for b in range(6):
                        normal[a, b] += row[a] * row[b]
    out = np.zeros(6)
    out[0] = total / max(1, count)
    if count > 8:
        ok, inverse = invert(normal)
        if ok:
            out = inverse @ rhs
            out[3:] *= BLUNTED
    return out


@numba.njit(cache=True, error_model="numpy")
def _mean_depth(depth: Floats, precision: Floats, mask: Bools) -> float:
    count, total = 0, 0.0
    for i in range(depth.shape[0]):
        for j in range(depth.shape[1]):
            if mask[i, j] and precision[i, j] > 0.0:
                count += 1
                total += depth[i, j]
    return total / max(1, count)


@numba.njit(cache=True, error_model="numpy")
def _round_start(
    depth: Floats, precision: Floats, mask: Bools, x: Floats, y: Floats, scale: float, height: float
) -> Floats:
    """A round dome over the mask, so much higher than what is felt."""
    top = cx = cy = 0.0
    count = 0
    for i in range(len(y)):
        for j in range(len(x)):
            if mask[i, j] and precision[i, j] > 0.0:
                top = max(top, depth[i, j])
                cx += x[j]
                cy += y[i]
                count += 1
    cx, cy = cx / max(1, count), cy / max(1, count)
    top = height * top + 1e-6
    px = x[1] - x[0] if len(x) > 1 else 1.0
    py = y[1] - y[0] if len(y) > 1 else 1.0
    k = 2.0 * top / max(count * px * py / np.pi, scale)
    return np.array([top - 0.5 * k * (cx * cx + cy * cy), k * cx, k * cy, k, 0.0, k])


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
) -> tuple[Floats, Floats, float, int, bool, Floats]:
    best = _fit_shape(
        depth,
        precision,
        x_cells,
        y_cells,
        to_columns,
        to_rows,
        start_dome(depth, precision, mask, x, y),
        DOME,
        STEPS,
        np.inf,
    )
    for attempt in range(3):
        dof = max(1, best[3] - 6)
        if best[2] < dof + ENOUGH * np.sqrt(2.0 * dof):
            break
        if attempt == 0:
            level = np.zeros(6)
            level[0] = _mean_depth(depth, precision, mask)
            level = _fit_shape(
                depth, precision, x_cells, y_cells, to_columns, to_rows, level, PLANE, STEPS, np.inf
            )[0]
        else:
            level = _round_start(depth, precision, mask, x, y, scale, float(attempt))
        other = _fit_shape(
            depth, precision, x_cells, y_cells, to_columns, to_rows, level, DOME, STEPS, np.inf
        )
        if other[2] < best[2]:
            best = other
    if not best[4]:
        other = _fit_shape(
            depth, precision, x_cells, y_cells, to_columns, to_rows, best[0], DOME, MORE_STEPS, np.inf
        )
        if other[4] or other[2] < best[2]:
            best = other
    return best[0], best[1], best[2], best[3], best[4], best[5]
