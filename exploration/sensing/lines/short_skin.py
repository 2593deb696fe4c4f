"""An outline polished once more where the skin ends soon past the outer taxels, and mirrors what spreads beyond.

The closed form knows of an endless skin only, and trusts the outer taxels less for that (`softened`).  Lines are
handed on to the forward model on cells, which knows the end of the skin, for a few steps.
"""

from dataclasses import replace

import numpy as np

from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.region import THREE, TWO
from exploration.sensing.lines.region_fit import RegionFit
from exploration.sensing.surfaces.footprint import PLANE, fit_footprint
from primitives.arrays import frozen

STEPS = 8


def on_its_skin(image: TactileImage, fit: RegionFit) -> RegionFit:
    """The same outline on the image's own skin; as it was where it is not made of lines."""
    n = len(fit.region.sides)
    if n == 0 or fit.region.signs or fit.region.terms in THREE[2:]:
        return fit
    start = np.concatenate([fit.parameters[:3], np.zeros(3), fit.parameters[3:]])
    union = fit.region.terms in (TWO[1], THREE[1])
    polished = fit_footprint(image, start, np.array(fit.region.sides), union, PLANE, steps=STEPS)
    if not np.all(np.diag(polished.covariance)[6:] > 0.0):
        return fit
    keep = [0, 1, 2, *range(6, 6 + 2 * n)]
    return replace(
        fit,
        parameters=frozen(polished.parameters[keep]),
        covariance=frozen(polished.covariance[np.ix_(keep, keep)]),
        chi2=polished.chi2,
        dof=polished.dof,
    )
