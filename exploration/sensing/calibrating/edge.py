"""The rubber's spread, from presses over a straight edge at unknown angles and offsets.

Each press is fitted with one line, a plane beside it and the spread that is tried (`footprint`, with the end of
the skin in the model); all presses share the spread.  With chi2(s) the sum over presses, each minimal over its
own line and plane, s is where it is least, and sigma^2 = 2 / chi2'' there, times chi2 / dof where the model does
not fit to the noise (our derivation).  One press alone knows its spread well, for a line leaves its blur to be
seen across many taxels; several, at several angles and offsets, average what each one's gains do to it.

Where the edge's response is not a Gaussian's, `family` gives the response of a spread, and the line is fitted
with it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from exploration.sensing.calibration import Calibration, correct
from exploration.sensing.frame import TactileImage, TaxelArray, TaxelFrame
from exploration.sensing.lines.hough import sure_lines
from exploration.sensing.lines.line import Line
from exploration.sensing.lines.line_fit import fit_line, softened
from exploration.sensing.response import Response
from exploration.sensing.surfaces.footprint import PLANE, fit_footprint
from primitives.arrays import Floats
from primitives.errors import PalpateError

LEAST_PRESSES = 3
RANGE = 2.5  # the spread is looked for within this factor of the nominal
_APART = 0.03  # of the spread, between the points that give the curvature of chi2


@dataclass(frozen=True)
class Spread:
    """Standard deviation of the point spread."""

    spread: float  # [mm]
    sigma: float  # [mm]
    chi2: float
    dof: int
    presses: int  # that showed an edge


def spread_from_edges(
    presses: Sequence[TaxelFrame],
    calibration: Calibration,
    array: TaxelArray,
    averaged: int = 1,
    family: Callable[[float], Response] | None = None,
) -> Spread:
    """The spread that explains presses over an edge best, each the mean of `averaged` frames."""
    known = replace(calibration, noise=calibration.noise / np.sqrt(averaged))
    images = [correct(press, known, array) for press in presses]
    found = [(image, lines[0]) for image in images if (lines := sure_lines(image, 1))]
    if len(found) < LEAST_PRESSES:
        raise PalpateError(
            f"{len(found)} of {len(presses)} presses show a straight edge; press one across the pad's middle, "
            f"{LEAST_PRESSES} times or more"
        )

    def misfit(log_spread: float) -> float:
        return sum(_chi2(image, line, float(np.exp(log_spread)), family)[0] for image, line in found)

    center = np.log(calibration.spread or max(array.pitch) / 2)
    best = minimize_scalar(
        misfit,
        bounds=(center - np.log(RANGE), center + np.log(RANGE)),
        method="bounded",
        options={"xatol": 1e-4},
    )
    spread = float(np.exp(best.x))
    chi2 = float(best.fun)
    dof = sum(_chi2(image, line, spread, family)[1] for image, line in found) - 1
    sides: Floats = np.array([misfit(best.x - _APART), misfit(best.x + _APART)])
    curvature = (sides.sum() - 2 * chi2) / _APART**2
    sigma = spread * np.sqrt(2.0 / max(curvature, 1e-12)) * np.sqrt(max(1.0, chi2 / max(1, dof)))
    return Spread(spread, float(sigma), chi2, dof, len(found))


def _chi2(
    image: TactileImage, line: Line, spread: float, family: Callable[[float], Response] | None
) -> tuple[float, int]:
    if family is not None:
        fit = fit_line(softened(image), family(spread), line.angle, line.offset, line.material_side)
        return fit.chi2, fit.dof
    sides = np.array([float(line.material_side)])
    plateau = float(np.quantile(image.depth[np.isfinite(image.sigma)], 0.9))
    start = np.array([plateau, 0.0, 0.0, 0.0, 0.0, 0.0, line.angle, line.offset])
    cut = fit_footprint(replace(image, spread=spread), start, sides, shape=PLANE)
    return cut.chi2, cut.dof
