"""The outline of a face as a hypothesis: which half-planes, joined how, and which bosses and holes.

A union or intersection of half-planes A, B, C is a sum over their subsets: A and B is AB, A or B is A + B - AB.
`terms` holds the coefficients, subset u having bit i set for line i; 1 stands for the whole plane.
"""

from dataclasses import dataclass
from functools import cached_property

import numba
import numpy as np

from primitives.arrays import Bools, Floats, frozen

Terms = tuple[float, ...]


@dataclass(frozen=True)
class Region:
    """The kind of an outline; its numbers are (d0, gx, gy), (angle, offset) a line, (x, y, radius) a disc."""

    sides: tuple[float, ...] = ()  # +1 where the material is on a line's positive side
    terms: Terms = (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    signs: tuple[float, ...] = ()  # +1 a boss, which needs terms of 0; -1 a hole

    @property
    def unknowns(self) -> int:
        """How many numbers it has."""
        return 3 + 2 * len(self.sides) + 3 * len(self.signs)

    @cached_property
    def arrays(self) -> tuple[Floats, Floats, Floats]:
        """Sides, terms and signs."""
        return frozen(self.sides), frozen(self.terms), frozen(self.signs)

    def holds(self, points: Floats, parameters: Floats) -> Bools:
        """(n,) whether the face is there, at (n, 2) points."""
        out: Bools = _held(points, parameters, *self.arrays)
        return out


@numba.njit(cache=True, error_model="numpy")
def _held(points: Floats, p: Floats, sides: Floats, terms: Floats, signs: Floats) -> Bools:
    n = len(sides)
    inside, out = np.zeros(len(points), np.int64), np.empty(len(points), np.bool_)
    for i in range(n):
        cosine, sine, offset = np.cos(p[3 + 2 * i]), np.sin(p[3 + 2 * i]), p[4 + 2 * i]
        for k in range(len(points)):
            if sides[i] * (points[k, 1] * cosine - points[k, 0] * sine - offset) > 0.0:
                inside[k] |= 1 << i
    for k in range(len(points)):
        cover = 0.0
        for u in range(len(terms)):
            if u & inside[k] == u:
                cover += terms[u]
        for j in range(len(signs)):
            at = 3 + 2 * n + 3 * j
            if np.hypot(points[k, 0] - p[at], points[k, 1] - p[at + 1]) < p[at + 2]:
                cover += signs[j]
        out[k] = cover > 0.5
    return out


def _terms(**subsets: float) -> Terms:
    """Coefficients by subset: `_terms(a=1, ab=-1)`."""
    out = [0.0] * 8
    for name, value in subsets.items():
        out[sum(1 << "abc".index(letter) for letter in name)] = value
    return tuple(out)


NO_TERMS = _terms()
WHOLE = Region().terms
ONE = (_terms(a=1),)
TWO = (_terms(ab=1), _terms(a=1, b=1, ab=-1))
THREE = (
    _terms(abc=1),
    _terms(a=1, b=1, c=1, ab=-1, ac=-1, bc=-1, abc=1),
    _terms(ab=1, ac=1, abc=-1),
    _terms(ab=1, bc=1, abc=-1),
    _terms(ac=1, bc=1, abc=-1),
    _terms(a=1, bc=1, abc=-1),
    _terms(b=1, ac=1, abc=-1),
    _terms(c=1, ab=1, abc=-1),
)
