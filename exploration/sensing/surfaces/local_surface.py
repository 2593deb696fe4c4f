"""The object's surface under the pad, from one frame: point, normal and curvature, with covariance.

The least-squares paraboloid of `footprint`, with the blur in the model: unmodeled, blur would pull the contact
point out by spread^2 / 2R and make a cylinder of radius 20 mm look a third blunter.  A plane is fitted first;
curvature is kept where it lowers chi2 by `WORTH`.  With g the gradient of the indentation at a point and H its
(negated) Hessian, the outward normal is (-gx, -gy, -1)/s, s^2 = 1 + |g|^2 (see `frame`), and the curvature in
tangent axes is T^t H T / s, T the coordinates of the tangent basis (convex is positive).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np

from exploration.sensing.contact_mask import contact_mask, usable
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.line import Line
from exploration.sensing.surfaces.footprint import PLANE, ROUND, Footprint, fit_footprint
from primitives.arrays import Bools, Floats, frozen
from primitives.pose import frame_along

WORTH = 20.0  # [chi2] that three curvatures must gain to be kept
AS_ROUND = 6.0  # [chi2] that two different principal curvatures must gain over equal ones (95 %)
ENOUGH = 3.0  # [standard deviations of chi2] within which no second start is tried
SIGNIFICANT = 4.0  # [sigma] of a principal curvature, for the contact point to follow it


NO_LINES = frozen(np.empty(0))


@dataclass(frozen=True)
class NoSurface:
    """Why there is none; false in a condition."""

    reason: str

    def __bool__(self) -> bool:
        return False


@dataclass(frozen=True)
class LocalSurface:
    """The surface in the sensor frame."""

    point: Floats  # (3,) [mm] where it is deepest within the contact, or the mask's centroid where it is flat
    normal: Floats  # (3,) outward unit normal of the object: about -z
    basis: Floats  # (3, 3) columns: two tangents, the first nearest to x, and the normal
    curvature: Floats  # (2, 2) [1/mm] in the tangents; positive where the object is convex
    curvature_covariance: Floats  # (3, 3) of kxx, kxy, kyy
    coefficients: Floats  # (6,) d0, gx, gy, kxx, kxy, kyy of depth(x, y) about the pad's center
    covariance: Floats  # (6, 6); zero for curvatures that were not needed
    curved: bool  # whether curvature was needed
    chi2: float
    dof: int
    mask: Bools  # (rows, columns) taxels in contact

    def depth_at(self, xy: Floats) -> Floats:
        """(n,) [mm] indentation of the unblurred surface at (n, 2) points of the pad."""
        depth: Floats = _monomials(np.atleast_2d(xy)) @ self.coefficients
        return depth

    def depth_sigma_at(self, xy: Floats) -> Floats:
        """(n,) [mm] its standard deviation."""
        m = _monomials(np.atleast_2d(xy))
        variance: Floats = np.einsum("ni,ij,nj->n", m, self.covariance, m)
        return np.sqrt(np.maximum(0.0, variance))

    @property
    def principal(self) -> tuple[Floats, Floats]:
        """Principal curvatures (2,), greatest first [1/mm], and their directions (2, 3) in the sensor frame."""
        values, vectors = np.linalg.eigh(self.curvature)
        return values[::-1], (self.basis[:, :2] @ vectors[:, ::-1]).T


def fit_surface(image: TactileImage, lines: Sequence[Line] = ()) -> LocalSurface | NoSurface:
    """The surface that a frame shows, cut by the lines that are given."""
    if not usable(image):
        return NoSurface("the frame holds values that are not finite, or no living taxel")
    mask = contact_mask(image)
    if not mask.any():
        return NoSurface("nothing is felt above the noise")
    cuts = np.array([value for line in lines for value in (line.angle, line.offset)])
    fit, curved = fit_smooth(image, mask, cuts, np.array([line.material_side for line in lines], dtype=float))
    if not fit.converged:
        return NoSurface("the fit of the sensor model did not converge")
    return surface_of(image, mask, fit, curved)


def fit_smooth(
    image: TactileImage, mask: Bools, cuts: Floats = NO_LINES, sides: Floats = NO_LINES
) -> tuple[Footprint, bool]:
    """The best plane, or the best paraboloid where it is worth it, cut by (angle, offset) pairs; is it curved?"""
    flat = np.concatenate([start_of(image, mask, False), cuts])
    best = fit_footprint(image, flat, sides) if len(sides) else fit_paraboloid(image, mask)
    if not _fits(best) or _wald(best) < 4 * WORTH:
        plane = fit_footprint(image, flat, sides, shape=PLANE)
        if not _fits(best) and len(sides):
            other = fit_footprint(image, plane.parameters, sides)
            best = other if other.chi2 < best.chi2 else best
        if plane.converged and plane.chi2 - best.chi2 < WORTH * max(1.0, best.chi2 / max(1, best.dof)):
            return plane, False
    kxx, _, kyy = best.parameters[3:6]
    if len(sides) or min(kxx, kyy) < 0.3 * max(kxx, kyy):
        return best, True
    start = best.parameters.copy()
    start[3:6] = (kxx + kyy) / 2, 0.0, (kxx + kyy) / 2
    ball = fit_footprint(image, start, sides, shape=ROUND)
    return (ball if ball.converged and ball.chi2 - best.chi2 < AS_ROUND else best), True


def fit_paraboloid(image: TactileImage, mask: Bools) -> Footprint:
    """The best smooth surface, from as many starts as it takes to explain the frame."""
    best = fit_footprint(image, start_of(image, mask, True), NO_LINES)
    if not _fits(best):
        plane = fit_footprint(image, start_of(image, mask, False), NO_LINES, shape=PLANE)
        for start in (plane.parameters, _dome(image, mask, 1.0), _dome(image, mask, 2.0)):
            other = fit_footprint(image, start, NO_LINES)
            best = other if other.chi2 < best.chi2 else best
            if _fits(best):
                break
    return best


def _fits(fit: Footprint) -> bool:
    return fit.chi2 < fit.dof + ENOUGH * sqrt(2 * max(1, fit.dof))


def start_of(image: TactileImage, mask: Bools, curved: bool) -> Floats:
    """Starting coefficients (6,): a least-squares plane or paraboloid of the deeper taxels."""
    keep = mask & np.isfinite(image.sigma)
    x, y = np.meshgrid(image.array.x, image.array.y)
    xy = np.stack([x[keep], y[keep]], axis=1)
    z = image.depth[keep]
    out = np.zeros(6)
    if curved and len(z) > 8:
        out[:] = np.linalg.lstsq(_monomials(xy), z, rcond=None)[0]
        out[3:] *= 1.3
    elif len(z):
        out[0] = float(z.mean())
    return out


def _wald(fit: Footprint) -> float:
    """[chi2] that curvature gains, to second order."""
    k = fit.parameters[3:6]
    return float(k @ np.linalg.solve(fit.covariance[3:6, 3:6], k)) if fit.converged else 0.0


def _dome(image: TactileImage, mask: Bools, height: float) -> Floats:
    """A round dome over the mask, so much higher than what is felt, for small contacts."""
    keep = mask & np.isfinite(image.sigma)
    x, y = np.meshgrid(image.array.x, image.array.y)
    px, py = image.array.pitch
    top = height * float(image.depth[keep].max(initial=0.0)) + 1e-6
    cx, cy = (float(x[keep].mean()), float(y[keep].mean())) if keep.any() else (0.0, 0.0)
    k = 2 * top / max(float(keep.sum()) * px * py / np.pi, image.spread**2)
    return np.array([top - 0.5 * k * (cx**2 + cy**2), k * cx, k * cy, k, 0.0, k])


def surface_of(image: TactileImage, mask: Bools, fit: Footprint, curved: bool) -> LocalSurface:
    """Point, normal and curvature of fitted coefficients."""
    c = np.array(fit.parameters[:6])
    inflation = max(1.0, fit.chi2 / max(1, fit.dof))
    covariance = fit.covariance[:6, :6] * inflation
    hessian = np.array([[c[3], c[4]], [c[4], c[5]]])
    xy = _deepest(image, mask, c, covariance)
    gradient = c[1:3] - hessian @ xy
    depth = float((_monomials(xy[None]) @ c)[0])
    outward = np.array([-gradient[0], -gradient[1], -1.0])
    scale = float(np.linalg.norm(outward))
    basis = frame_along(outward / scale, np.array([1.0, 0.0, 0.0]))
    tangents = basis[:2, :2]
    pairs = ((0, 0), (0, 1), (1, 1))
    turn = np.array([_products(tangents[:, a], tangents[:, b]) for a, b in pairs]) / scale
    return LocalSurface(
        point=frozen([xy[0], xy[1], -depth]),
        normal=frozen(outward / scale),
        basis=frozen(basis),
        curvature=frozen(tangents.T @ hessian @ tangents / scale),
        curvature_covariance=frozen(turn @ covariance[3:, 3:] @ turn.T),
        coefficients=frozen(c),
        covariance=frozen(covariance),
        curved=curved,
        chi2=fit.chi2,
        dof=fit.dof,
        mask=frozen(mask, np.bool_),
    )


def _deepest(image: TactileImage, mask: Bools, c: Floats, covariance: Floats) -> Floats:
    """From the mask's centroid, along each curved principal direction, to the greatest depth within the mask."""
    x, y = np.meshgrid(image.array.x, image.array.y)
    xy = np.stack([x[mask], y[mask]], axis=1)
    center: Floats = xy.mean(axis=0)
    hessian = np.array([[c[3], c[4]], [c[4], c[5]]])
    gradient = c[1:3] - hessian @ center
    values, vectors = np.linalg.eigh(hessian)
    out = center.copy()
    for value, e in zip(values, vectors.T, strict=True):
        weights = np.array([e[0] ** 2, 2 * e[0] * e[1], e[1] ** 2])
        sigma = float(np.sqrt(max(0.0, weights @ covariance[3:, 3:] @ weights)))
        if value > SIGNIFICANT * sigma and value > 0.0:
            span = (xy - center) @ e
            out += float(np.clip(gradient @ e / value, span.min(), span.max())) * e
    return out


def _products(a: Floats, b: Floats) -> list[float]:
    """The factors of kxx, kxy and kyy in a^t K b."""
    return [a[0] * b[0], a[0] * b[1] + a[1] * b[0], a[1] * b[1]]


def _monomials(xy: Floats) -> Floats:
    x, y = xy[:, 0], xy[:, 1]
    return np.stack([np.ones_like(x), x, y, -0.5 * x * x, -x * y, -0.5 * y * y], axis=1)
