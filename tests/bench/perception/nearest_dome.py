"""The dome nearest to a press, of those that are smooth: least squares within bounds.

The smooth fit's own best dome may be too sharp, or have its pole too far away, where one that is neither explains
a small contact nearly as well: what the frame leaves open is long and bent.  So pole, depth there, curvatures and
lean are each held to what is smooth, and all are free within.
"""

from itertools import product

import numpy as np
from scipy.optimize import least_squares

from exploration.sensing.surfaces.smooth_fit import SmoothContact
from exploration.sensing.surfaces.smooth_shapes import DOME
from exploration.sensing.surfaces.smooth_steps import fit_from
from primitives.arrays import Floats

EVALUATIONS = 40


def nearest_dome(
    contact: SmoothContact, sharpest: float, away: float, deepest: float, steepest: float
) -> float:
    """[chi2] from a press to the nearest dome that is smooth.

    Its curvatures are at most `sharpest` [1/mm], its pole is within `away` [mm] of the pad's center and `deepest`
    [mm] deep, and it leans by `steepest` [rad] besides.
    """
    high = np.array([away, away, deepest, sharpest, sharpest, np.pi, steepest, steepest])
    low = np.array([-away, -away, 0.0, 0.0, 0.0, -np.pi, -steepest, -steepest])
    gx, gy = np.meshgrid(contact.x, contact.y)
    touched = contact.depth * contact.mask
    middle = np.clip([(touched * g).sum() / touched.sum() for g in (gx, gy)], -0.9 * away, 0.9 * away)
    top = float(np.clip(contact.depth.max(), 0.1 * deepest, 0.9 * deepest))
    least = np.inf
    for share, (k1, k2) in product((0.5, 1.0), ((0.9, 0.9), (0.9, 0.1))):
        turn = np.arctan2(middle[1], middle[0])
        start = np.array([*(share * middle), top, k1 * sharpest, k2 * sharpest, turn, 0.0, 0.0])
        end = least_squares(
            _left, start, bounds=(low, high), x_scale=high, max_nfev=EVALUATIONS, args=(contact,)
        )
        least = min(least, 2.0 * float(end.cost))
    return least


def _left(n: Floats, contact: SmoothContact) -> Floats:
    """[sigma] residuals of a dome."""
    x, y, top, k1, k2, turn, tilt_x, tilt_y = n.tolist()
    axes = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    bend = axes @ np.diag([k1, k2]) @ axes.T
    at = np.array([x, y])
    slope = bend @ at + [tilt_x, tilt_y]
    depth = top - 0.5 * at @ bend @ at - at @ [tilt_x, tilt_y]
    p = np.array([depth, *slope, bend[0, 0], bend[0, 1], bend[1, 1]])
    return fit_from(contact.depth, contact.precision, *contact.grid, p, DOME, 0, np.inf)[5].ravel()
