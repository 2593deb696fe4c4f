"""The radius to which an edge is rounded, from the mean profile of depth across it.

A face pressed z0 deep, with the slope b, ends in an arc of radius r that turns by beta, the dihedral angle's
supplement.  With s the distance inside the edge that the two faces would meet in, the arc begins at
L = r tan(beta / 2) and

    depth(s) = z0 + b s                                   for s >= L,
    depth(s) = z0 + b s - (r - sqrt(r^2 - (L - s)^2))     on the arc,

and falls along the second face beyond it; it ends where it comes out of the skin, or where a steep arc stands
upright.  The skin shows its integral against the response: sum of d depth(s_k) edge((t - s_k) / w).  Unknown
are r, z0, b and where the edge as it was fitted lies from the faces' meeting (our derivation).

A narrow face ends opposite, too, and what is missing there looks like a long arc here.  It is taken off as that of
a sharp edge, z0 edge((t - f) / w), f unknown as well, where that explains the profile clearly better.

A rounding widens the response by little (0.4 % at 0.5 mm): one frame cannot tell it, a track's profile can, as
well as the response's own width is known.  The radius enters by its square, so that of a nearly sharp edge the
likeliest is 0 as often as not.  What is told is the mean over all radii that the profile allows, every one before
touch as good as another, and their standard deviation: with C(r) the least chi2 over the other unknowns, the width
among them, p(r) ~ exp(-C(r) / 2) (our derivation).
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import OptimizeResult, least_squares

from exploration.sensing.response import REACH, Response
from primitives.arrays import Floats

STARTS = (0.3, 1.0, 2.5, 6.0)  # [mm]
GREATEST = 20.0  # [mm]
SHIFT = 12.0  # [mm] at most, of the edge as it was fitted from the faces' meeting
FLOOR = 0.04  # share of the greatest depth, below which readings may be cut off at the converter's zero
AROUND, RADII = 1.5, 31  # [mm] about the likeliest radius, either way, and how many radii are weighed there
MODEL = 0.004  # [mm] of the width, as well as its table knows the response
FAR = (-2.0, 1.0, 5.0)  # [mm] past the profile's end: where a face ends opposite at least, likely and at most
BETTER = 9.0  # chi2 by which such an end must better the fit
POOR = 50.0  # misfit beyond which no rounding explains the profile
STEP = 0.05  # [mm] of the profile before it is spread
FROM, TO = -10.0, 16.0  # [mm] of it


@dataclass(frozen=True)
class Rounding:
    """How an edge is rounded; false where no rounding explains what was felt of it."""

    radius: float  # [mm]
    sigma: float  # [mm]
    misfit: float  # chi2 per degree of freedom

    def __bool__(self) -> bool:
        return self.misfit < POOR


def rounding_of(
    place: Floats,
    depth: Floats,
    sigma: Floats,
    width: float,
    response: Response,
    dihedral: float,
    known: float,
) -> Rounding:
    """The rounding of an edge of `dihedral` [rad] whose profile is (n,) depths at (n,) places, all [mm].

    `width` [mm] is the response's, known to `known` [mm].
    """
    felt = depth > FLOOR * depth.max()
    place, depth, sigma = place[felt], depth[felt], sigma[felt]
    doubt = float(np.hypot(known, MODEL))

    def missed(p: Floats) -> Floats:
        """Of radius, press, slope, shift, width and, if told, the opposite end: of all places, and the width."""
        shown = spread(place - p[3], p[0], p[1], p[2], p[4], response, dihedral)
        if len(p) > 5:
            shown = shown - p[1] * response.edge(place - p[5], p[4])
        return np.append((shown - depth) / sigma, (p[4] - width) / doubt)

    deepest = float(np.quantile(depth, 0.9))
    ends = place.max() + np.array(FAR)
    low = np.array([0.0, 0.1 * deepest, -0.3, -SHIFT, 0.5 * width, ends[0]])
    high = np.array([GREATEST, 3.0 * deepest, 0.3, SHIFT, 2.0 * width, ends[2]])
    scale = np.array([1.0, 0.1, 0.01, 0.5, 0.01, 0.5])

    def fitted(count: int) -> OptimizeResult:
        """The best fit of that many unknowns."""
        fits = []
        for r in STARTS:
            start = [r, deepest, 0.0, -half_height(r, deepest, np.pi - dihedral), width, ends[1]][:count]
            fits.append(
                least_squares(missed, start, bounds=(low[:count], high[:count]), x_scale=scale[:count])
            )
        return min(fits, key=lambda fit: float(fit.cost))

    best, narrow = fitted(5), fitted(6)
    free = max(1, len(depth) - 4)
    if 2.0 * float(best.cost - narrow.cost) > BETTER * max(1.0, 2.0 * float(narrow.cost) / free):
        best = narrow
    misfit = 2.0 * float(best.cost) / free
    count = len(best.x)
    radii = np.linspace(max(0.0, best.x[0] - AROUND), min(GREATEST, best.x[0] + AROUND), RADII)
    left, chi2 = best.x[1:], np.empty(RADII)
    for k, r in enumerate(radii.tolist()):

        def elsewhere(q: Floats, r: float = r) -> Floats:
            return missed(np.append(r, q))

        fit = least_squares(elsewhere, left, bounds=(low[1:count], high[1:count]), x_scale=scale[1:count])
        left, chi2[k] = fit.x, 2.0 * float(fit.cost) / max(1.0, misfit)
    share = np.exp(-0.5 * (chi2 - chi2.min()))
    share /= share.sum()
    mean = float(share @ radii)
    return Rounding(
        mean, float(np.sqrt(share @ (radii - mean) ** 2 + (radii[1] - radii[0]) ** 2 / 12.0)), misfit
    )


def spread(
    t: Floats, radius: float, press: float, slope: float, width: float, response: Response, dihedral: float
) -> Floats:
    """(n,) [mm] what the skin shows (n,) [mm] inside where the faces would meet."""
    s = np.arange(FROM, TO, STEP)
    steps = np.diff(pressed(s, radius, press, slope, np.pi - dihedral))
    reach = int(np.ceil(REACH * width / STEP))
    kernel = np.diff(response.edge((np.arange(-reach, reach + 2) - 0.5) * STEP, width))
    grown = np.cumsum(np.convolve(steps, kernel))[reach : reach + len(s) - 1]
    out: Floats = np.interp(t, s[1:], grown, left=0.0)
    return out


def pressed(s: Floats, radius: float, press: float, slope: float, turn: float) -> Floats:
    """(n,) [mm] how deep a rounded edge that turns by `turn` [rad] lies in the skin."""
    begins = radius * np.tan(0.5 * turn)
    past = np.maximum(0.0, begins - s)  # of the arc
    steepest = radius * np.sin(min(turn, 0.5 * np.pi))
    on = np.minimum(past, steepest)
    drop = radius - np.sqrt(np.maximum(radius**2 - on**2, 0.0))
    if turn < 0.5 * np.pi - 1e-6:
        drop = drop + (past - on) * np.tan(turn)
    depth = np.maximum(0.0, press + slope * s - drop)
    return depth if turn < 0.5 * np.pi - 1e-6 else np.where(past <= steepest, depth, 0.0)


def half_height(radius: float, press: float, turn: float) -> float:
    """[mm] inside where the faces would meet, where a rounded edge lies half as deep as its face."""
    s = np.arange(FROM, TO, STEP)
    return float(s[np.argmax(pressed(s, radius, press, 0.0, turn) > 0.5 * press)])
