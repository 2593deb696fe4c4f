"""How likely contacts are to lie on one face, its parameters integrated out.

Laplace's approximation, with chi2 at the best fit, P the covariance there and p the density that the parameters
had before any touch::

    -ln evidence = chi2 / 2 - ln p - ln det(2 pi P) / 2 - ln prior of the kind.

Before any touch every direction is as likely, a face passes anywhere within the extent L of all contacts, and
what bends it is its curvature 1 / r, even between +-100 / L, so that a radius has the density L / (200 r^2): a
flat face is no likelier to be a huge cylinder than it should be.  A contact alone is a plane of its own, with
P = diag(sigma^2, normal_sigma^2, normal_sigma^2) and chi2 = 0 (our derivation).
"""

from __future__ import annotations

import numpy as np

from primitives.arrays import Floats
from primitives.fit import Fit
from primitives.shapes import Cone, Cylinder, Shape, Sphere, Torus

PRIOR = {"plane": 0.5, "cylinder": 0.3, "cone": 0.08, "sphere": 0.06, "torus": 0.06}
_BENDS = 200.0  # [1 / extent] range of the curvatures of a face


def alone(sigma: float, normal_sigma: float, extent: float) -> float:
    """[nats] of a contact on a plane of its own."""
    tight = np.array([sigma / extent, normal_sigma, normal_sigma])
    return float(
        np.log(4 * np.pi / PRIOR["plane"]) - np.log(np.sqrt(2 * np.pi) * np.minimum(tight, 1.0)).sum()
    )


def alone_without_normal(sigma: float, extent: float) -> float:
    """[nats] of a contact anywhere, of which no normal was felt."""
    return float(np.log(extent / (np.sqrt(2 * np.pi) * min(sigma, extent))) + np.log(1 / PRIOR["plane"]))


def price(found: Fit, extent: float, center: Floats) -> float:
    """[nats] of a face beside the chi2 / 2 of its contacts, whose middle is `center` (3,) [mm]."""
    shape = found.shape
    first = len(shape.translations)
    scale = np.full(shape.dof, 1.0 / extent)
    scale[first : first + shape.tilts] = 1.0
    if isinstance(shape, Cone):
        scale[-1] = 1.0
    information = np.linalg.pinv(found.covariance * np.outer(scale, scale), hermitian=True)
    known = np.arange(first, first + shape.tilts)
    information[known, known] += 1.0
    tight = -np.linalg.slogdet(information / (2 * np.pi))[1]
    return float(-_log_density(shape, extent, center) - np.log(PRIOR[found.kind]) - 0.5 * tight)


def rough_price(kind: str, single: float) -> float:
    """[nats] of a face before it is fitted: of a lone contact, and a quarter more for each parameter more."""
    more = {"plane": 0.0, "sphere": 1.0, "cylinder": 2.0, "cone": 3.0, "torus": 4.0}[kind]
    return single + more * single / 4.0 - float(np.log(PRIOR[kind] / PRIOR["plane"]))


def _log_density(shape: Shape, extent: float, center: Floats) -> float:
    """Of parameters before any touch, lengths in extents."""
    if isinstance(shape, Sphere):
        r = shape.radius / extent
        return float(-np.log(max(1.0, 4 * np.pi * r * r)) - np.log(_BENDS * r * r))
    if isinstance(shape, Cylinder):
        r = shape.radius / extent
        return float(-np.log(2 * np.pi * max(1.0, 2 * np.pi * r)) - np.log(_BENDS * r * r))
    if isinstance(shape, Torus):
        r, tube = shape.radius / extent, shape.minor_radius / extent
        return float(-np.log(2 * np.pi * max(1.0, 4 * np.pi * r * r)) - np.log(_BENDS * tube * tube))
    if isinstance(shape, Cone):
        slope = float(np.tan(shape.semi_angle))
        r = max(abs(float((center - shape.apex) @ shape.axis)) * slope, 1e-3 * extent) / extent
        spread = 4 * np.pi * np.pi / 2 * max(1.0, 2 * np.pi * r)
        return float(-np.log(spread) - np.log(_BENDS * r * r) + np.log(slope))
    return float(-np.log(4 * np.pi))
