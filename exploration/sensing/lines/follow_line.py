"""An edge that is expected, followed from one frame to the next: no search, one fit (`bent_edge`), one kernel.

One frame tells kappa to some 0.005 /mm only; what is expected of it enters as one more reading, so that from
frame to frame it is filtered as Kalman would.

Blurring a bent edge moves its half-height crossing by kappa w^2 / 2 toward the hollow side (the heat flow that a
Gaussian blur is, to second order), which is taken off the offset.

What is not that edge is looked for first (`face_ends`) and left out.
"""

from collections.abc import Sequence

import numba
import numpy as np

from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.bent_edge import chosen, weighed
from exploration.sensing.lines.face_ends import face_ends
from exploration.sensing.lines.followed import Expected, Followed
from exploration.sensing.response import Response
from exploration.sensing.surfaces.normal_equations import invert
from primitives.arrays import Bools, Floats, frozen

STEPS = 8
SETTLED = 0.05  # chi2 that a step gains, after which the line stands
CLEAR = 1.5  # [response widths] kept from such ends
BENT = 0.05  # [1/mm] of an edge that comes round under the pad
LEAST = 12  # taxels that a fit needs
TILT = 0.05  # [mm/mm] of a pad that is kept level; a face of few taxels says little of it


def follow_line(image: TactileImage, response: Response, expected: Expected) -> Followed:
    """Fit the expected edge to a frame; `image` as `softened` where the skin ends near the pad."""
    px, py = image.array.pitch
    p, covariance, misfit, ends, contact, found = _follow(
        image.depth,
        image.sigma,
        px,
        py,
        response.table,
        response.variance,
        (expected.angle, expected.offset, float(expected.side), expected.bend),
        expected.bend_sigma,
        expected.reach,
    )
    return Followed(p, covariance, expected.side, misfit, ends, contact, found)


def follow_lines(
    images: Sequence[TactileImage], response: Response, lines: Floats, bend_sigmas: Floats, reaches: Floats
) -> tuple[Floats, Floats, Bools]:
    """The same of many frames of one array: (n, 6) parameters, (n, 6, 6) covariances, and which were found.

    `lines` (n, 4) are angle, offset, side and bend.
    """
    found: tuple[Floats, Floats, Bools] = _follow_all(
        frozen([image.depth for image in images]),
        frozen([image.sigma for image in images]),
        images[0].array.pitch,
        response.table,
        response.variance,
        lines,
        bend_sigmas,
        reaches,
    )
    return found


@numba.njit(cache=True, error_model="numpy")
def _follow_all(
    depth: Floats,
    sigma: Floats,
    pitch: tuple[float, float],
    table: Floats,
    variance: Floats,
    lines: Floats,
    bend_sigmas: Floats,
    reaches: Floats,
) -> tuple[Floats, Floats, Bools]:
    n = len(lines)
    parameters, covariances = np.empty((n, 6)), np.empty((n, 6, 6))
    found = np.zeros(n, dtype=np.bool_)
    for k in range(n):
        angle, offset, side, bend = lines[k]
        parameters[k], covariances[k], _, _, _, found[k] = _follow(
            depth[k],
            sigma[k],
            pitch[0],
            pitch[1],
            table,
            variance,
            (angle, offset, side, bend),
            bend_sigmas[k],
            reaches[k],
        )
    return parameters, covariances, found


@numba.njit(cache=True, error_model="numpy")
def _follow(
    depth: Floats,
    sigma: Floats,
    px: float,
    py: float,
    table: Floats,
    variance: Floats,
    line: tuple[float, float, float, float],
    bend_sigma: float,
    reach: float,
) -> tuple[Floats, Floats, float, Floats, Floats, bool]:
    angle, offset, side, bend = line
    normal, rhs = np.zeros((6, 6)), np.zeros(6)
    sa, ca = np.sin(angle), np.cos(angle)
    width = np.sqrt(variance[0] * sa * sa + variance[1] * ca * ca)
    p = np.array([angle, offset, 0.0, 0.0, 0.0, bend])
    covariance = np.zeros((6, 6))
    ends, deep, contact, level = face_ends(depth, sigma, px, py, angle, offset, side, bend, width)
    if level <= 0.0:
        return p, covariance, 0.0, ends, contact, False
    clear = CLEAR * width
    low, high = -ends[1] + clear, min(ends[0], ends[2]) - clear
    looked = ends[4] if abs(bend) < BENT else np.inf  # a bent edge's wedge of taxels ends by itself
    far = max(min(ends[3], looked) - clear, 0.5 * width)  # beyond what was looked at it may end, too
    deep = np.maximum(deep - clear, 0.5 * width)
    taxels = chosen(depth, sigma, px, py, line, (low, high, far, reach), deep)
    count = len(taxels)
    if count < LEAST:
        return p, covariance, 0.0, ends, contact, False
    p[2] = level
    prior = (bend, bend_sigma, TILT)
    chi2 = weighed(taxels, table, width, p, side, prior, normal, rhs)
    damping, settled = 0.0, False
    for _ in range(STEPS):
        damped = normal.copy()
        for a in range(6):
            damped[a, a] *= 1.0 + damping
        ok, inverse = invert(damped)
        if not ok:
            return p, covariance, 0.0, ends, contact, False
        step = inverse @ rhs
        gained = step @ rhs
        if damping == 0.0 and gained < SETTLED:  # so short a step leads where the normal equations say
            p, chi2, covariance, settled = p + step, chi2 - gained, inverse, True
            break
        trial = p + step
        new = weighed(taxels, table, width, trial, side, prior, normal, rhs)
        if not new < chi2 + 1e-9:
            weighed(taxels, table, width, p, side, prior, normal, rhs)
            damping = max(1e-2, 10.0 * damping)
            if damping > 1e2:
                break
            continue
        gained = chi2 - new
        p, chi2 = trial, new
        damping = 0.1 * damping if damping > 1e-3 else 0.0
        if gained < SETTLED:
            break
    if not settled:
        ok, covariance = invert(normal)
    p[1] -= side * 0.5 * p[5] * width * width
    strong = ok and p[2] > 5.0 * np.sqrt(covariance[2, 2])
    near = abs(p[0] - angle) < 0.5 and abs(p[1] - offset) < 4.0 * width
    return p, covariance, chi2 / max(1, count - 5), ends, contact, strong and near
