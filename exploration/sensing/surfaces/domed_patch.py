"""The domed part of a contact of any outline: a paraboloid through the taxels that no edge blurs.

As `flat_patch`, for a small round face whose rim is not straight.  Two taxels inside the outline the rubber's
spread s and the taxel's own width p only lower a paraboloid of Hessian -K by (s^2 + p^2 / 12) tr(K) / 2, which is
added back (our derivation).  What the fit knows is handed out as five points, in its middle and on either side
along its principal axes, each of five times the variance that the fit has there.
"""

from dataclasses import dataclass

import numpy as np

from exploration.sensing.frame import TactileImage
from exploration.sensing.surfaces.in_world import in_world
from exploration.sensing.surfaces.inner_taxels import inner_taxels
from primitives.arrays import Bools, Floats
from primitives.evidence import Contacts


@dataclass(frozen=True)
class DomedPatchConfig:
    """When the inside of a contact is a smooth dome."""

    taxels: int = 14
    misfit: float = 1.5  # chi2 per degree of freedom of the paraboloid
    spread: float = 1.5  # [mm] least standard deviation of the taxels' places, along the narrower axis
    sharpest: float = 0.12  # [1/mm]
    floor: float = 0.02  # [mm] error that the noise does not show
    normal_floor: float = 0.01  # [rad]


def domed_patch(
    image: TactileImage,
    inner: Bools,
    world_from_sensor: Floats,
    touch: int,
    stroke: int,
    sensor: int,
    config: DomedPatchConfig = DomedPatchConfig(),
) -> Contacts:
    """Five contacts on the dome under the (rows, columns) `inner` taxels; none where there is none."""
    none = Contacts.of(np.empty((0, 3)))
    taxels = inner_taxels(image, inner, config.taxels, config.spread)
    if taxels is None:
        return none
    center, values, vectors = taxels.center, taxels.variances, taxels.axes
    depth, sigma = taxels.depth, taxels.sigma
    basis = _monomials(taxels.offsets)
    information = (basis / sigma[:, None] ** 2).T @ basis
    covariance = np.linalg.inv(information)
    c: Floats = covariance @ (basis.T @ (depth / sigma**2))
    misfit = float((((depth - basis @ c) / sigma) ** 2).sum()) / (len(depth) - 6)
    hessian = np.array([[c[3], c[4]], [c[4], c[5]]])
    if misfit > config.misfit or float(np.abs(np.linalg.eigvalsh(hessian)).max()) > config.sharpest:
        return none
    lowered = 0.5 * (image.spread**2 + float(np.mean(np.square(image.array.pitch))) / 12) * (c[3] + c[5])
    arms = np.sqrt(values) * vectors
    at = np.concatenate([np.zeros((1, 2)), arms.T, -arms.T])
    m = _monomials(at)
    slope = c[1:3] - at @ hessian
    variance = len(at) * np.einsum("ni,ij,nj->n", m, covariance, m)
    turn = len(at) * float(np.diag(covariance)[1:3].mean())
    return in_world(
        center + at,
        m @ c + lowered,
        slope,
        np.sqrt(variance + config.floor**2),
        float(np.hypot(np.sqrt(turn), config.normal_floor)),
        world_from_sensor,
        touch,
        stroke,
        sensor,
    )


def _monomials(xy: Floats) -> Floats:
    x, y = xy[:, 0], xy[:, 1]
    return np.stack([np.ones_like(x), x, y, -0.5 * x * x, -x * y, -0.5 * y * y], axis=1)
