"""Whether a frame needs its lines: edges against smooth surfaces, and how many edges.

An edge is where the measured depth drops clearly below what the extrapolated local surface predicts.  A single
line that fits the noise, on a plateau that is nearly as deep at the edge as anywhere, is one.  Everything else is
compared with a smooth paraboloid that has no edge at all: lines join, strongest first, while each lowers chi2 by
`WORTH`, all lines and the surface being fitted together (`footprint`), as corner and wall or as inside corner and
slot.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exploration.sensing.contact_mask import contact_mask
from exploration.sensing.footprint import Footprint, fit_footprint
from exploration.sensing.frame import TactileImage
from exploration.sensing.local_surface import start_of
from primitives.arrays import Floats

WORTH = 25.0  # [chi2] that a line must gain
SMOOTH = 4.0  # [standard deviations of chi2] within which a paraboloid explains the frame


@dataclass(frozen=True)
class JointFit:
    """Lines and surface of one frame, fitted together; false where no line is needed."""

    fit: Footprint
    sides: Floats  # (n,)
    chosen: tuple[int, ...]  # indices of the candidates

    def __bool__(self) -> bool:
        return bool(self.chosen)


def fit_lines(image: TactileImage, cuts: Sequence[tuple[float, float, int]]) -> JointFit:
    """Which (angle, offset, material side) candidates the frame needs, polished together."""
    mask = contact_mask(image)
    best = JointFit(fit_footprint(image, start_of(image, mask, True), np.empty(0)), np.empty(0), ())
    if best.fit.chi2 < best.fit.dof + SMOOTH * np.sqrt(2 * best.fit.dof):
        return best
    plane = start_of(image, mask, False)
    for k in range(len(cuts)):
        trials = [
            _trial(image, plane, cuts, (*best.chosen, k), union)
            for union in (False, True)[: 1 + len(best.chosen)]
        ]
        trial = min(trials, key=lambda t: t.fit.chi2)
        scale = max(1.0, trial.fit.chi2 / trial.fit.dof)
        if best.fit.chi2 - trial.fit.chi2 > WORTH * scale:
            best = trial
    return best


def _trial(
    image: TactileImage,
    plane: Floats,
    cuts: Sequence[tuple[float, float, int]],
    chosen: tuple[int, ...],
    union: bool,
) -> JointFit:
    sides = np.array([cuts[k][2] for k in chosen], dtype=float)
    start = np.concatenate([plane, *([cuts[k][0], cuts[k][1]] for k in chosen)])
    fit = fit_footprint(image, start, sides, union=union, curved=False)
    if fit.chi2 > fit.dof + SMOOTH * np.sqrt(2 * fit.dof):
        curved = fit_footprint(image, fit.parameters, sides, union=union, curved=True)
        if fit.chi2 - curved.chi2 > WORTH and curved.converged:
            fit = curved
    return JointFit(fit, sides, chosen)
