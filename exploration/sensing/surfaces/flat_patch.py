"""The flat part of a contact of any outline: a plane through the taxels that no edge blurs.

Where contact ends along an arc or in several corners, no straight line describes its outline, but two taxels
inside it the spread of the rubber is symmetric and a plane is felt as it is (our derivation).  The plane's
least-squares information is handed out as four points whose own plane fit has the same covariance.
"""

from dataclasses import dataclass

import numpy as np

from exploration.sensing.frame import TactileImage
from exploration.sensing.surfaces.in_world import in_world
from exploration.sensing.surfaces.inner_taxels import inner_taxels
from primitives.arrays import Bools, Floats
from primitives.evidence import Contacts


@dataclass(frozen=True)
class FlatPatchConfig:
    """When the inside of a contact is flat enough."""

    taxels: int = 12
    misfit: float = 1.6  # chi2 per degree of freedom of the plane
    spread: float = 1.5  # [mm] least standard deviation of the taxels' places, along the narrower axis


def flat_patch(
    image: TactileImage,
    inner: Bools,
    world_from_sensor: Floats,
    touch: int,
    stroke: int,
    sensor: int,
    config: FlatPatchConfig = FlatPatchConfig(),
) -> Contacts:
    """Four contacts on the plane under the (rows, columns) `inner` taxels; none where they are not flat."""
    none = Contacts.of(np.empty((0, 3)))
    taxels = inner_taxels(image, inner, config.taxels, config.spread)
    if taxels is None:
        return none
    center, values, vectors = taxels.center, taxels.variances, taxels.axes
    depth, sigma = taxels.depth, taxels.sigma
    basis = np.column_stack([np.ones(len(depth)), taxels.offsets])
    plane, *_ = np.linalg.lstsq(basis / sigma[:, None], depth / sigma, rcond=None)
    misfit = float((((depth - basis @ plane) / sigma) ** 2).sum()) / (len(depth) - 3)
    if misfit > config.misfit:
        return none
    arms = np.sqrt(2.0 * values) * vectors
    at = np.concatenate([arms.T, -arms.T])
    each = float(np.median(sigma)) * 2.0 / np.sqrt(len(depth))
    return in_world(
        center + at,
        plane[0] + at @ plane[1:],
        np.tile(plane[1:], (4, 1)),
        each,
        float(np.sqrt(2.0 / values.min())) * each,  # as `sensing/contacts.py` has it
        world_from_sensor,
        touch,
        stroke,
        sensor,
    )
