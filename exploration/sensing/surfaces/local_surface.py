"""The object's surface under the pad, from one frame: point, normal, curvature and order, with covariance.

The least-squares smooth contact (`smooth_fit`) of the likeliest order (`order`), or a dome cut by the lines that
are given (`footprint`), both with the blur in the model: unmodeled, blur would pull the contact point out by
spread^2 / 2R and make a cylinder of radius 20 mm look a third blunter.  What is
read off the fitted coefficients is in `anatomy`.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exploration.sensing.calibration import CLIPPED
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.line import Line
from exploration.sensing.surfaces.anatomy import STRAIGHT, anatomy
from exploration.sensing.surfaces.footprint import PLANE, Footprint, fit_footprint
from exploration.sensing.surfaces.order import Ordered, order_alone, order_contact
from exploration.sensing.surfaces.pressed_field import dome_at
from exploration.sensing.surfaces.smooth_fit import SmoothContact, fit_dome, smooth_contact
from exploration.sensing.surfaces.smooth_starts import start_dome
from primitives.arrays import Bools, Floats, frozen
from primitives.curvature import ORDERS


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
    covariance: Floats  # (6, 6); that of its order: a plane's curvatures have none, a ball's are one
    curved: bool  # whether curvature was needed
    orders: Floats  # (4,) probabilities of `primitives.curvature.ORDERS`
    chi2: float
    dof: int
    mask: Bools  # (rows, columns) taxels in contact

    @property
    def order(self) -> str:
        """The likeliest of `primitives.curvature.ORDERS`."""
        return ORDERS[int(np.argmax(self.orders))]

    def depth_at(self, xy: Floats) -> Floats:
        """(n,) [mm] indentation of the unblurred surface at (n, 2) points of the pad."""
        return np.array([dome_at(self.coefficients, x, y)[0] for x, y in np.atleast_2d(xy)])

    def slope_at(self, xy: Floats) -> Floats:
        """(n, 2) gradient of the indentation."""
        return np.array([dome_at(self.coefficients, x, y)[1:] for x, y in np.atleast_2d(xy)]).reshape(-1, 2)

    def depth_sigma_at(self, xy: Floats) -> Floats:
        """(n,) [mm] standard deviation of the indentation."""
        m = _monomials(np.atleast_2d(xy))
        variance: Floats = np.einsum("ni,ij,nj->n", m, self.covariance, m)
        return np.sqrt(np.maximum(0.0, variance))

    @property
    def principal(self) -> tuple[Floats, Floats]:
        """Principal curvatures (2,), greatest first [1/mm], and their directions (2, 3) in the sensor frame."""
        values, vectors = np.linalg.eigh(self.curvature)
        return values[::-1], (self.basis[:, :2] @ vectors[:, ::-1]).T

    @property
    def principal_sigma(self) -> Floats:
        """(2,) [1/mm] standard deviations of the principal curvatures."""
        _, vectors = np.linalg.eigh(self.curvature)
        a, b = vectors[:, ::-1]
        m = np.stack([a * a, 2 * a * b, b * b], axis=1)
        variance: Floats = np.einsum("ni,ij,nj->n", m, self.curvature_covariance, m)
        return np.sqrt(np.maximum(0.0, variance))

    @property
    def radius(self) -> tuple[float, float]:
        """[mm] of the sharpest normal section, negative in a hollow, and its sigma; (inf, inf) of a plane."""
        values, sigmas = self.principal[0], self.principal_sigma
        sharpest = int(np.argmax(np.abs(values)))
        k = float(values[sharpest])
        if not self.curved or abs(k) < STRAIGHT:
            return np.inf, np.inf
        return 1.0 / k, float(sigmas[sharpest]) / k**2


def fit_surface(image: TactileImage, lines: Sequence[Line] = ()) -> LocalSurface | NoSurface:
    """The surface that a frame shows, cut by the lines that are given."""
    contact = smooth_contact(image)
    if contact is None:
        return NoSurface("the frame holds values that are not finite, or no living taxel")
    if not contact:
        return NoSurface("nothing is felt above the noise")
    if lines:
        return _cut_surface(image, contact, lines)
    dome = fit_dome(contact)
    if not dome.converged:
        return NoSurface("the fit of the sensor model did not converge")
    return ordered_surface(image, contact, order_contact(contact, dome))


def ordered_surface(image: TactileImage, contact: SmoothContact, found: Ordered) -> LocalSurface:
    """A smooth surface of the order that it most likely has."""
    return surface_of(image, contact.mask, found.fit, found.curved, found.probability)


def _cut_surface(
    image: TactileImage, contact: SmoothContact, lines: Sequence[Line]
) -> LocalSurface | NoSurface:
    plane, dome, orders = fit_cut(image, lines)
    if not dome.converged and not plane.converged:
        return NoSurface("the fit of the sensor model did not converge")
    curved = bool(orders[0] < 0.5)
    return surface_of(image, contact.mask, dome if curved else plane, curved, orders)


def fit_cut(image: TactileImage, lines: Sequence[Line]) -> tuple[Footprint, Footprint, Floats]:
    """The best plane and the best dome that these lines cut, and the orders' probabilities."""
    cuts = np.array([value for line in lines for value in (line.angle, line.offset)])
    sides = np.array([line.material_side for line in lines], dtype=float)
    level = np.concatenate([[float(lines[0].plateau)], np.zeros(5), cuts])
    plane = fit_footprint(image, level, sides, shape=PLANE)
    dome = fit_footprint(image, plane.parameters if plane.converged else level, sides)
    if not dome.converged:
        return plane, dome, np.array([1.0, 0.0, 0.0, 0.0])
    inflation = max(1.0, dome.chi2 / max(1, dome.dof))
    orders = order_alone(dome.parameters[:6], dome.covariance[:6, :6] * inflation)
    if not plane.converged:
        orders = np.array([0.0, *orders[1:]]) / max(1e-12, float(orders[1:].sum()))
    return plane, dome, orders


def fit_paraboloid(image: TactileImage, mask: Bools) -> Footprint:
    """The best smooth surface of any two curvatures, from as many starts as it takes to explain the frame."""
    contact = smooth_contact(image, mask)
    if contact is None:
        return Footprint(np.zeros(6), np.zeros((6, 6)), np.inf, 1, False, np.zeros(image.depth.shape))
    return fit_dome(contact)


def start_of(image: TactileImage, mask: Bools, curved: bool) -> Floats:
    """Starting coefficients (6,): a least-squares level plane or paraboloid of the touched taxels."""
    array = image.array
    alive = np.isfinite(image.sigma)
    depth = np.where(alive, image.depth, 0.0)
    if curved:
        dome: Floats = start_dome(depth, alive.astype(float), mask, array.x, array.y)
        return dome
    keep = mask & alive
    level = np.zeros(6)
    level[0] = float(depth[keep].mean()) if keep.any() else 0.0
    return level


def surface_of(
    image: TactileImage, mask: Bools, fit: Footprint, curved: bool, orders: Floats | None = None
) -> LocalSurface:
    """Point, normal and curvature of fitted coefficients."""
    inflation = max(1.0, fit.chi2 / max(1, fit.dof))
    c, covariance = np.ascontiguousarray(fit.parameters[:6]), fit.covariance[:6, :6] * inflation
    covariance[0, 0] += _left_open(image, mask) ** 2
    if orders is None:
        orders = order_alone(c, covariance)
    point, normal, basis, curvature, spread = anatomy(c, covariance, mask, image.array.x, image.array.y)
    for array in (point, normal, basis, curvature, spread, c, covariance, mask):
        array.flags.writeable = False
    return LocalSurface(
        point,
        normal,
        basis,
        curvature,
        spread,
        c,
        covariance,
        curved,
        frozen(orders),
        fit.chi2,
        fit.dof,
        mask,
    )


def _left_open(image: TactileImage, mask: Bools) -> float:
    """[mm] of depth that saturated taxels leave open together: what lies deeper lies deeper under all of them.

    `CLIPPED` of their depth whatever their characteristic, and however many frames were averaged.
    """
    if image.saturated is None:
        return 0.0
    clipped = mask & image.saturated & np.isfinite(image.sigma)
    return CLIPPED * float(image.depth[clipped].sum()) / max(1, int(mask.sum()))


def _monomials(xy: Floats) -> Floats:
    x, y = xy[:, 0], xy[:, 1]
    return np.stack([np.ones_like(x), x, y, -0.5 * x * x, -x * y, -0.5 * y * y], axis=1)
