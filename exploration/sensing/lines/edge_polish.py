"""Gauss-Newton on `edge_model`, weights of noise, gain and dead taxels renewed at every step.

Residuals beyond 3 sigma count by their size until the line is near, and then as what they are likelier: noise, or
taxels that died without telling.  The iteration ends when a step gains less than `DONE` in chi2; that last step is
taken but not evaluated, for Newton's error after it is the square of what is left.
"""

import numba
import numpy as np

from exploration.sensing.lines.edge_model import (
    ALONG,
    ANGLE,
    BACKGROUND,
    OFFSET,
    RISE,
    UNKNOWNS,
    design,
    products,
    solve,
)
from primitives.arrays import Floats, Ints

STEPS = 12
DONE = 0.05  # [chi2]
NEAR = 4.0  # [chi2] to gain, from which on outliers are taken for dead taxels
TURN, SHIFT = 0.3, 0.8  # [rad], [widths] the largest step
TILT = (
    0.15  # standard deviation of the prior of the plateau's slopes: pads meet faces within about 10 degrees
)
TARED = 1.0  # [sigma of a taxel] standard deviation of the prior of the background


@numba.njit(cache=True, error_model="numpy")
def polish(
    z: Floats,
    variance: Floats,
    gain: float,
    quiet: float,
    views: Floats,
    kinds: Ints,
    first: Ints,
    blurs: Floats,
    table: Floats,
    p: Floats,
    side: float,
    fall: float,
    rows: Floats,
    normal: Floats,
    rhs: Floats,
) -> tuple[float, int]:
    """Improve `p` (UNKNOWNS,) in place; chi2, or -1 if it does not settle, and the taxels alive.

    `normal` is left as the information at the end, `rows` with the design there.
    """
    widths = np.empty(len(blurs))
    lower, step = np.zeros((UNKNOWNS, UNKNOWNS)), np.zeros(UNKNOWNS)
    certainty = 1.0 / np.sqrt(variance)
    slopes, ground = 1.0 / TILT**2, 1.0 / (TARED * quiet) ** 2
    least = np.inf  # [chi2] gained by a step so far
    for _ in range(STEPS):
        chi2, count = design(
            z,
            variance,
            certainty,
            gain,
            views,
            kinds,
            first,
            blurs,
            table,
            p,
            side,
            fall,
            least < NEAR,
            widths,
            rows,
        )
        products(rows, UNKNOWNS, normal, rhs)
        for a, prior in ((RISE, slopes), (ALONG, slopes), (BACKGROUND, ground)):
            chi2 += prior * p[a] * p[a]
            normal[a, a] += prior
            rhs[a] -= prior * p[a]
        if not solve(normal, rhs, UNKNOWNS, lower, step):
            return -1.0, count
        gained = 0.0
        for a in range(UNKNOWNS):
            gained += step[a] * rhs[a]
        share = min(
            1.0,
            TURN / max(1e-12, abs(step[ANGLE])),
            SHIFT * widths[0] / max(1e-12, abs(step[OFFSET])),
        )
        for a in range(UNKNOWNS):
            p[a] += share * step[a]
        if least < NEAR and gained < DONE:
            return chi2 - gained, count
        least = min(least, gained)
    return -1.0, count
