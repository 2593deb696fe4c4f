"""Cubic smoothing splines of several columns at once, as stiff as told or as readings that were held out ask for.

Of all curves g the natural cubic spline with knots at the readings has the least

    sum w (y - g)^2 + stiffness * (integral of g''^2).

With h the spacings, Q (n, n-2) the second differences divided by them and R (n-2, n-2) the tridiagonal matrix of
the hat functions' products, its second derivatives c solve a system of five bands, and its values follow
(Reinsch 1967; Green and Silverman 1994, section 2.3):

    (R + stiffness Q' W^-1 Q) c = Q' y,      g = y - stiffness W^-1 Q c.

Every column shares the matrix, so a point of space costs one factorization.  An infinitely stiff spline is the
least-squares line.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg.lapack import dpbsv

from primitives.arrays import Floats, frozen

STEP = 1e-3  # readings nearer than this are one


@dataclass(frozen=True)
class Spline:
    """A natural cubic spline of several columns; straight beyond its ends."""

    knots: Floats  # (n,) increasing
    values: Floats  # (n, k)
    bends: Floats  # (n, k) second derivatives, zero at the ends

    def at(self, s: Floats, order: int = 0) -> Floats:
        """(m, k) the curve at (m,) places, or its first derivative."""
        inside = np.clip(s, self.knots[0], self.knots[-1])
        i = np.clip(np.searchsorted(self.knots, inside, side="right") - 1, 0, len(self.knots) - 2)
        h = (self.knots[i + 1] - self.knots[i])[:, None]
        u = (inside - self.knots[i])[:, None] / h
        low, high = self.values[i], self.values[i + 1]
        bend_low, bend_high = self.bends[i], self.bends[i + 1]
        turned = (3.0 * u**2 - 1.0) * bend_high - (3.0 * (1.0 - u) ** 2 - 1.0) * bend_low
        slope = (high - low) / h + h / 6.0 * turned
        if order == 1:
            return np.asarray(slope)
        share = _between(self.knots[i], self.knots[i + 1], inside)
        curve = share[0] * low + share[1] * high + share[2] * bend_low + share[3] * bend_high
        return np.asarray(curve + (s - inside)[:, None] * slope)


@dataclass(frozen=True)
class Readings:
    """Readings at increasing places, ready to be smoothed."""

    places: Floats  # (n,)
    columns: Floats  # (n, k)
    weights: Floats  # (n,)

    def smoothed(self, stiffness: float) -> Spline:
        """The smoothing spline; the least-squares line where it is infinitely stiff."""
        if not np.isfinite(stiffness):
            return self._line()
        hats, penalty, bend = self._system
        _, inner, failed = dpbsv(hats + stiffness * penalty, bend)
        if failed:
            return self._line()
        bends = np.zeros_like(self.columns)
        bends[1:-1] = inner
        h = np.diff(self.places)[:, None]
        push = np.zeros_like(self.columns)
        slopes = (bends[1:] - bends[:-1]) / h
        push[:-1] = slopes
        push[1:] -= slopes
        return Spline(self.places, self.columns - (stiffness / self.weights)[:, None] * push, bends)

    def missed(self, stiffness: float) -> float:
        """The weighted squares by which splines through every other reading miss those between them."""
        total = 0.0
        for half, held, share in self._halves:
            spline, n = half.smoothed(stiffness), len(held.places)
            if len(spline.knots) == 2:
                off = spline.at(held.places) - held.columns
            else:
                ends = spline.values[:n], spline.values[1 : n + 1], spline.bends[:n], spline.bends[1 : n + 1]
                off = share[0] * ends[0] + share[1] * ends[1] + share[2] * ends[2] + share[3] * ends[3]
                off -= held.columns
            total += float(held.weights @ np.einsum("ij,ij->i", off, off))
        return total

    @cached_property
    def _halves(self) -> list[tuple["Readings", "Readings", Floats]]:
        """Every other reading, those between them, and how values and bends of either side make one; twice."""
        found = []
        for first in (0, 1):
            half, held = self._some(slice(first, None, 2)), self._some(slice(first + 1, -1, 2))
            n = len(held.places)
            found.append((half, held, _between(half.places[:n], half.places[1 : n + 1], held.places)))
        return found

    def _some(self, which: slice) -> "Readings":
        return Readings(self.places[which], self.columns[which], self.weights[which])

    @cached_property
    def _system(self) -> tuple[Floats, Floats, Floats]:
        """Upper bands (3, n-2) of R and of Q' W^-1 Q; Q' y."""
        h, soft = np.diff(self.places), 1.0 / self.weights
        before, after = 1.0 / h[:-1], 1.0 / h[1:]
        middle = -(before + after)
        hats, penalty = np.zeros((3, len(middle))), np.zeros((3, len(middle)))
        hats[2] = (h[:-1] + h[1:]) / 3.0
        hats[1, 1:] = h[1:-1] / 6.0
        penalty[2] = soft[:-2] * before**2 + soft[1:-1] * middle**2 + soft[2:] * after**2
        penalty[1, 1:] = soft[1:-2] * middle[:-1] * before[1:] + soft[2:-1] * after[:-1] * middle[1:]
        penalty[0, 2:] = soft[2:-2] * after[:-2] * before[2:]
        return hats, penalty, np.diff(np.diff(self.columns, axis=0) / h[:, None], axis=0)

    def _line(self) -> Spline:
        total = self.weights.sum()
        place = float(self.weights @ self.places) / total
        mean = self.weights @ self.columns / total
        lever = self.weights * (self.places - place)
        slope = lever @ self.columns / float(lever @ (self.places - place))
        ends = self.places[[0, -1]]
        return Spline(frozen(ends), mean + np.outer(ends - place, slope), np.zeros((2, len(mean))))


def travel_along(points: Floats, tangents: Floats) -> Floats:
    """(n,) lengths from the first point: steps along the tangents, which noise across them does not lengthen."""
    middle = tangents[1:] + tangents[:-1]
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    return np.concatenate([[0.0], np.cumsum(np.sum(np.diff(points, axis=0) * middle, axis=1))])


def in_order(places: Floats, most: int, *columns: Floats) -> tuple[Floats, ...]:
    """Increasing places and their columns; more than `most` are averaged in groups, and none is at another's."""
    order = np.argsort(places, kind="stable")
    size = max(1, int(np.ceil(len(places) / most)))
    s, *rest = (_grouped(values[order], size) for values in (places, *columns))
    apart = np.concatenate([[True], np.diff(s) > STEP])
    return (s[apart], *(values[apart] for values in rest))


def _grouped(values: Floats, size: int) -> Floats:
    """Means of every `size` values in turn."""
    whole = len(values) // size * size
    means: Floats = values[:whole].reshape(-1, size, *values.shape[1:]).mean(axis=1)
    return means


def _between(before: Floats, after: Floats, at: Floats) -> Floats:
    """(4, m, 1) shares of the values and of the bends before and after each place."""
    h = after - before
    u = (at - before) / h
    left, right = ((1.0 - u) ** 3 - (1.0 - u)) * h**2 / 6.0, (u**3 - u) * h**2 / 6.0
    return np.stack([1.0 - u, u, left, right])[:, :, None]
