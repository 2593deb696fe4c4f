"""The surface under a sliding pad, every tick: the full contact model, begun where the last frame left it.

The smooth contact of two free curvatures (`smooth_fit`) has the rubber's blur and the end of contact in it, so
that its depth and slope have no bias where `feel`'s paraboloid has one.  From one tick to the next it hardly
moves, and one or two steps find it again.  Where an edge cuts the contact, the model does not hold, which is soon
seen; then only the taxels that no edge blurs are fitted.
"""

from dataclasses import dataclass, replace

import numpy as np

from exploration.control.feel import Felt
from exploration.devices.guard import Observation
from exploration.sensing.surfaces.footprint import Footprint
from exploration.sensing.surfaces.smooth_fit import SmoothContact, fit_dome, fit_shape, smooth_contact
from exploration.sensing.surfaces.smooth_shapes import DOME, UNKNOWNS
from primitives.arrays import Floats, frozen

MISFIT = 4.0  # [standard deviations of chi2] beyond which something cuts the contact
PLAIN = 1.5  # the same, within which a smooth surface leaves no edge to find
LEAST = 15  # taxels that a fit of part of a contact needs


@dataclass(frozen=True)
class SurfaceReading:
    """One tick of a stroke."""

    coefficients: Floats  # (6,) d0, gx, gy, kxx, kxy, kyy of depth(x, y) about the pad's center
    covariance: Floats  # (6, 6)
    whole: bool  # whether the model explains the frame, and
    plain: bool  # so well that there is no edge to look for
    world_from_sensor: Floats  # (4, 4)
    force: float  # [N]

    @property
    def slope(self) -> Floats:
        """(2,) of depth at the pad's center."""
        return self.coefficients[1:3]

    @property
    def hessian(self) -> Floats:
        """(2, 2) [1/mm], positive where convex."""
        _, _, _, a, b, c = self.coefficients
        return np.array([[a, b], [b, c]])

    @property
    def depth_sigma(self) -> float:
        """[mm] at the pad's center."""
        return float(np.sqrt(max(self.covariance[0, 0], 0.0)))

    @property
    def slope_sigma(self) -> float:
        """[rad] per axis."""
        return float(np.sqrt(max(0.5 * (self.covariance[1, 1] + self.covariance[2, 2]), 0.0)))

    def depth_at(self, xy: Floats) -> float:
        """[mm] at a (2,) place of the pad."""
        return float(self.coefficients[0] + xy @ self.slope - 0.5 * xy @ self.hessian @ xy)

    @property
    def point(self) -> Floats:
        """(3,) [mm] of the surface under the pad's center."""
        pose = self.world_from_sensor
        point: Floats = pose[:3, 3] - self.coefficients[0] * pose[:3, 2]
        return point

    @property
    def normal(self) -> Floats:
        """(3,) outward normal there."""
        normal: Floats = self.world_from_sensor[:3, :3] @ np.array([-self.slope[0], -self.slope[1], -1.0])
        return normal / np.linalg.norm(normal)


def read_surface(seen: Observation, felt: Felt, last: SurfaceReading | None = None) -> SurfaceReading | None:
    """The surface in one frame, looked for where the last one had it; None where no fit is found."""
    contact = smooth_contact(seen.image, felt.mask)
    if not contact:
        return None
    divisible = int(np.count_nonzero(felt.inner)) >= LEAST
    fit = _fitted(contact, last, MISFIT if divisible else np.inf)
    whole, plain = _explains(fit, MISFIT), _explains(fit, PLAIN)
    if not whole and divisible:
        inner = frozen(felt.inner, np.bool_)  # as every mask is, for which kernels are compiled once
        part = replace(contact, precision=np.where(inner, contact.precision, 0.0), mask=inner)
        fit = _fitted(part, last)
    if not fit.converged or not np.isfinite(fit.parameters).all():
        return None
    inflation = max(1.0, fit.chi2 / max(1, fit.dof))
    return SurfaceReading(
        fit.parameters[:6],
        fit.covariance[:6, :6] * inflation,
        whole,
        plain,
        seen.world_from_sensor,
        seen.force,
    )


def _fitted(contact: SmoothContact, last: SurfaceReading | None, deviations: float = np.inf) -> Footprint:
    """From the last reading, or afresh where that leads nowhere.

    Given up, unconverged, once it promises to be more than so many `deviations` of chi2 off.
    """
    if last is None:
        return fit_dome(contact)
    dof = int(np.count_nonzero(contact.precision)) - UNKNOWNS[DOME]
    limit = dof + deviations * np.sqrt(2.0 * max(1, dof))
    fit = fit_shape(contact, _began(last), DOME, limit)
    return fit if fit.converged or limit < fit.chi2 else fit_dome(contact)


def _began(last: SurfaceReading) -> Footprint:
    c = last.coefficients
    return Footprint(c, last.covariance, np.inf, 1, True, c)


def _explains(fit: Footprint, deviations: float) -> bool:
    return bool(fit.converged and fit.chi2 < fit.dof + deviations * np.sqrt(2.0 * fit.dof))
