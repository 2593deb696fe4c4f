"""A smooth surface through contacts, where no plane, cylinder, cone, sphere or torus is: a Gaussian process.

Of a field f that is nothing on the surface, less inside and more outside, each contact tells two things: that f is
0 there, and that its gradient is the outward normal.  Both are told with noise to a Gaussian process whose
covariance is that of a thin plate (Williams and Fitzgibbon 2007; of touch, Dragiev, Toussaint and Gienger 2011)::

    k(r) = (2 r^3 - 3 R r^2 + R^3) / 6 R,

R a distance that no two places exceed.  Its scale gives gradients unit variance before anything was felt, as those
of a distance have, so that near the surface f is the distance from it in mm.  Places elsewhere may be known to lie
so far outside or inside.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from primitives.arrays import Floats
from primitives.errors import PalpateError

_AROUND = 2.6  # times the largest distance from the middle, that R is
_SLOPE = 0.1  # noise of gradients beside that of normals, for f is no distance but near the surface


@dataclass(frozen=True)
class ImplicitSurface:
    """Where the field of (n,) values' and (m, 3) slopes' weights is nothing."""

    middle: Floats  # (3,) [mm]
    values_at: Floats  # (n, 3) [mm] from the middle
    slopes_at: Floats  # (m, 3) [mm]
    value_weights: Floats  # (n,)
    slope_weights: Floats  # (m, 3)
    longest: float  # R [mm]

    def values(self, points: Floats) -> Floats:
        """(k,) the field at (k, 3) points: near the surface the distance from it [mm], negative inside."""
        at = np.ascontiguousarray(points - self.middle)
        out = np.empty(len(at))
        _add_up(at, self.values_at, self.value_weights, self.slopes_at, self.slope_weights, self.longest, out)
        return out


def implicit_surface(
    points: Floats,
    normals: Floats,
    sigma: Floats,
    normal_sigma: Floats,
    elsewhere: Floats | None = None,
    outside: Floats | None = None,
) -> ImplicitSurface:
    """The surface through (n, 3) contacts [mm] with unit normals, known to (n,) [mm] and [rad].

    Of (m, 3) places elsewhere it is told that they lie (m,) [mm] outside, within half as much; less than nothing
    is inside.  PalpateError where no surface has these contacts, as of one place.
    """
    rest = np.empty((0, 3)) if elsewhere is None else elsewhere
    away = np.zeros(len(rest)) if outside is None else outside
    middle = points.mean(axis=0)
    valued = np.concatenate([points, rest]) - middle
    longest = _AROUND * float(np.linalg.norm(valued, axis=1).max())
    if longest == 0.0:
        raise PalpateError("a surface needs contacts at more than one place")
    sloped = np.ascontiguousarray(points - middle)
    n, m = len(valued), len(sloped)
    told = np.concatenate([np.zeros(m), away, normals.T.ravel()])
    noise = np.concatenate([sigma, 0.5 * np.abs(away), np.tile(np.hypot(normal_sigma, _SLOPE), 3)])
    covariance = _covariance(valued, sloped, longest)
    covariance[np.arange(n + 3 * m), np.arange(n + 3 * m)] += noise**2
    try:
        weights = cho_solve(cho_factor(covariance, lower=True, overwrite_a=True), told)
    except LinAlgError:
        raise PalpateError("the contacts allow no smooth surface") from None
    slopes = np.ascontiguousarray(weights[n:].reshape(3, m).T)
    return ImplicitSurface(middle, valued, sloped, weights[:n], slopes, longest)


def _covariance(valued: Floats, sloped: Floats, longest: float) -> Floats:
    """(n + 3 m, n + 3 m) of values at (n, 3) places and slopes at (m, 3), without noise; all x slopes first."""
    n, m = len(valued), len(sloped)
    out = np.empty((n + 3 * m, n + 3 * m))
    r = np.linalg.norm(valued[:, None] - valued, axis=2)
    out[:n, :n] = (2.0 * r**3 - 3.0 * longest * r**2 + longest**3) / (6.0 * longest)
    apart = sloped[:, None] - valued
    change = (np.linalg.norm(apart, axis=2) / longest - 1.0)[..., None] * apart
    apart = sloped[:, None] - sloped
    r = np.linalg.norm(apart, axis=2)
    inverse = 1.0 / np.where(r > 0.0, r, 1.0)
    for a in range(3):
        rows = slice(n + a * m, n + (a + 1) * m)
        out[rows, :n] = change[..., a]
        out[:n, rows] = change[..., a].T
        for b in range(3):
            out[rows, n + b * m : n + (b + 1) * m] = (a == b) * (1.0 - r / longest) - (
                apart[..., a] * apart[..., b] * inverse / longest
            )
    return out


@njit(cache=True, error_model="numpy")
def _add_up(
    points: Floats,
    values_at: Floats,
    value_weights: Floats,
    slopes_at: Floats,
    slope_weights: Floats,
    longest: float,
    out: Floats,
) -> None:
    for p in range(len(points)):
        total = 0.0
        for i in range(len(values_at)):
            x = points[p, 0] - values_at[i, 0]
            y = points[p, 1] - values_at[i, 1]
            z = points[p, 2] - values_at[i, 2]
            square = x * x + y * y + z * z
            total += value_weights[i] * (
                square * (2.0 * np.sqrt(square) - 3.0 * longest) / (6.0 * longest) + longest * longest / 6.0
            )
        for i in range(len(slopes_at)):
            x = points[p, 0] - slopes_at[i, 0]
            y = points[p, 1] - slopes_at[i, 1]
            z = points[p, 2] - slopes_at[i, 2]
            along = slope_weights[i, 0] * x + slope_weights[i, 1] * y + slope_weights[i, 2] * z
            total -= along * (np.sqrt(x * x + y * y + z * z) / longest - 1.0)
        out[p] = total
