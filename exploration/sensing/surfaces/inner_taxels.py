"""The taxels inside a contact, and how wide they spread: what a patch of any outline is read from."""

from dataclasses import dataclass

import numpy as np

from exploration.sensing.frame import TactileImage
from primitives.arrays import Bools, Floats


@dataclass(frozen=True)
class InnerTaxels:
    """Living taxels of a contact that no edge blurs."""

    center: Floats  # (2,) [mm]
    offsets: Floats  # (n, 2) [mm] of the taxels from the center
    depth: Floats  # (n,) [mm]
    sigma: Floats  # (n,) [mm]
    variances: Floats  # (2,) [mm^2] of the offsets along their principal axes, the lesser first
    axes: Floats  # (2, 2) columns


def inner_taxels(image: TactileImage, inner: Bools, least: int, spread: float) -> InnerTaxels | None:
    """The (rows, columns) `inner` taxels; none if fewer than `least`, or narrower than `spread` [mm]."""
    rows, columns = np.nonzero(inner & np.isfinite(image.sigma))
    if len(rows) < least:
        return None
    xy = np.stack([image.array.x[columns], image.array.y[rows]], axis=1)
    center = xy.mean(axis=0)
    variances, axes = np.linalg.eigh(np.cov((xy - center).T))
    if variances[0] < spread**2:
        return None
    return InnerTaxels(
        center, xy - center, image.depth[rows, columns], image.sigma[rows, columns], variances, axes
    )
