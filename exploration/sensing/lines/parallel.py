"""Two sides of one wall, bar or slot are parallel where the frame does not say otherwise.

A hypothesis with a number less is nested in the free one.  With A p = 0 saying that two angles are equal and C
the free fit's covariance, the constrained optimum and its covariance follow from the free one,

    p' = p - C A^t (A C A^t)^-1 A p,    C' = C - C A^t (A C A^t)^-1 A C,

and chi2 grows by (A p)^t (A C A^t)^-1 A p, which Schwarz lets it by the logarithm of the number of taxels.  To
first order only: a line of which so little is seen that it might lie along any other is left as it is.
"""

from dataclasses import replace
from itertools import combinations
from math import log, pi

import numpy as np

from exploration.sensing.lines.region_fit import RegionFit

NEARLY = 0.3  # [rad] apart


def made_parallel(fit: RegionFit) -> RegionFit:
    """The fit with those pairs of lines parallel whose angles differ by no more than chance."""
    for i, j in combinations(range(len(fit.region.sides)), 2):
        a, b = 3 + 2 * i, 3 + 2 * j
        apart = (fit.parameters[a] - fit.parameters[b] + pi / 2) % pi - pi / 2
        if abs(apart) > NEARLY:
            continue
        row = np.zeros(len(fit.parameters))
        row[a], row[b] = 1.0, -1.0
        gain = fit.covariance @ row
        variance = float(row @ gain) * fit.inflation
        rise = apart * apart / max(variance, 1e-18)
        if rise < log(fit.dof + len(row)):
            scale = 1.0 / max(float(row @ gain), 1e-18)
            fit = replace(
                fit,
                parameters=fit.parameters - gain * (apart * scale),
                covariance=fit.covariance - np.outer(gain, gain) * scale,
                chi2=fit.chi2 + rise * fit.inflation,
                dof=fit.dof + 1,
            )
    return fit
