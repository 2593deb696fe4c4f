"""Whether a frame needs its lines: edges against smooth surfaces, and how many edges.

An edge is where the measured depth drops clearly below what the extrapolated local surface predicts.  A long
line on a high plateau is compared with a rim without a step (`line_fit`, order 1), which costs 20 us, and only
when that is close with a smooth paraboloid.  Everything else is compared with the paraboloid: lines join,
strongest first, while each lowers chi2 by `WORTH`, all lines and the surface being fitted together
(`footprint`), as corner and wall or as inside corner and slot.

One flank of a cylinder and an edge differ little: at 0.5 mm and 5 % noise by 20 to 600 in chi2 mostly, at 10 %
often by nothing.  So the likelier of a long line and a smooth surface is taken, except that a lone flank sharper
than `SHARP` must be `PRIOR` likelier than an edge (our choice: thin bars are rarer than faces).  Short lines,
further lines and lines in curved faces have smooth alternatives nested in them, and must gain `WORTH`.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exploration.sensing.contact_mask import contact_mask
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.line_fit import LineFit
from exploration.sensing.surfaces.footprint import PLANE, Footprint, fit_footprint
from exploration.sensing.surfaces.local_surface import fit_paraboloid, start_of
from primitives.arrays import Floats

WORTH = 25.0  # [chi2] that a short or further line, or a curved face beside the lines, must gain
SHARP = 0.04  # [1/mm]
PRIOR = 4.0  # [chi2]
CURVED = 4.0  # [standard deviations of chi2] of misfit from which the cut surface may curve


def worth(greatest: float, least: float = 0.0) -> float:
    """[chi2] that a long line must gain on a smooth surface of these principal curvatures [1/mm]."""
    return -PRIOR if greatest > SHARP and abs(least) < 0.2 * greatest else 0.0


@dataclass(frozen=True)
class JointFit:
    """Lines and surface of one frame, fitted together; false where no line is needed."""

    fit: Footprint
    sides: Floats  # (n,)
    chosen: tuple[int, ...]  # indices of the candidates

    def __bool__(self) -> bool:
        return bool(self.chosen)


def polish(image: TactileImage, line: LineFit, side: int) -> JointFit:
    """One line that stands, fitted once more with the end of the skin in the model."""
    angle, offset, height, rise, along = line.parameters.tolist()
    e = np.array([np.cos(angle), np.sin(angle)])
    n = np.array([-e[1], e[0]])
    g = rise * side * n + along * e
    start = np.array([height - rise * side * offset, g[0], g[1], 0.0, 0.0, 0.0, angle, offset])
    sides = np.array([float(side)])
    return JointFit(fit_footprint(image, start, sides, shape=PLANE), sides, (0,))


def beats_smooth(image: TactileImage, chi2: float) -> bool:
    """Whether a single line of this chi2 is likelier than the best smooth surface."""
    smooth = fit_paraboloid(image, contact_mask(image))
    return smooth.chi2 - chi2 > _worth(smooth) or not smooth.converged


def beats_rim(image: TactileImage, chi2: float, rim: LineFit, side: int) -> bool:
    """The same, the best smooth surface being next to a fitted rim (`line_fit`, order 1).

    The rim's (A + c v) t + b t^2/2, with t = s (n . p - rho) and v = e . p, is a paraboloid in p.
    """
    angle, offset, slope, bend, turn = (float(value) for value in rim.parameters)
    e = np.array([np.cos(angle), np.sin(angle)])
    n = np.array([-e[1], e[0]])
    g = slope * side * n - turn * side * offset * e - bend * offset * n
    k = -bend * np.outer(n, n) - turn * side * (np.outer(e, n) + np.outer(n, e))
    d0 = -slope * side * offset + bend * offset**2 / 2
    start = np.array([d0, g[0], g[1], k[0, 0], k[0, 1], k[1, 1]])
    smooth = fit_footprint(image, start, np.empty(0))
    return smooth.chi2 - chi2 > _worth(smooth)


def fit_lines(image: TactileImage, cuts: Sequence[tuple[float, float, int]], sure: bool = False) -> JointFit:
    """Which (angle, offset, material side) candidates the frame needs, polished together.

    `sure` says that there is one candidate, long and on a high plateau.
    """
    mask = contact_mask(image)
    best = JointFit(fit_paraboloid(image, mask), np.empty(0), ())
    plane = start_of(image, mask, False)
    for k in range(len(cuts)):
        trial = _best_trial(image, plane, cuts, (*best.chosen, k), best.fit.chi2)
        curved = bool(np.any(trial.fit.parameters[3:6]))
        needed = _worth(best.fit) if sure and not best and not curved else WORTH
        if _gain(best, trial) > needed:
            best = trial
    if not best and len(cuts) > 1:
        pair = _best_trial(image, plane, cuts, (0, 1), best.fit.chi2)
        best = pair if _gain(best, pair) > WORTH else best
    return best


def _gain(old: JointFit, new: JointFit) -> float:
    return (old.fit.chi2 - new.fit.chi2) / max(1.0, new.fit.chi2 / max(1, new.fit.dof))


def _best_trial(
    image: TactileImage,
    plane: Floats,
    cuts: Sequence[tuple[float, float, int]],
    chosen: tuple[int, ...],
    limit: float,
) -> JointFit:
    trials = [_trial(image, plane, cuts, chosen, union, limit) for union in (False, True)[: len(chosen)]]
    return min(trials, key=lambda trial: trial.fit.chi2)


def _trial(
    image: TactileImage,
    plane: Floats,
    cuts: Sequence[tuple[float, float, int]],
    chosen: tuple[int, ...],
    union: bool,
    limit: float,
) -> JointFit:
    """The fit of these lines, given up where chi2 will not come below `limit`."""
    sides = np.array([cuts[k][2] for k in chosen], dtype=float)
    start = np.concatenate([plane, *([cuts[k][0], cuts[k][1]] for k in chosen)])
    fit = fit_footprint(image, start, sides, union=union, shape=PLANE, limit=limit)
    if fit.chi2 > fit.dof + CURVED * np.sqrt(2 * fit.dof):
        curved = fit_footprint(image, fit.parameters, sides, union=union, limit=limit)
        if fit.chi2 - curved.chi2 > WORTH and curved.converged:
            fit = curved
    return JointFit(fit, sides, chosen)


def _worth(fit: Footprint) -> float:
    kxx, kxy, kyy = fit.parameters[3:6]
    mean, half = (kxx + kyy) / 2, float(np.hypot((kxx - kyy) / 2, kxy))
    return worth(mean + half, mean - half)
