"""How likely contacts are to lie where they do along a surface: drawn from all of it, or near those before.

Nobody knows how a finger went about.  If it came from anywhere each time, every place has the density 1 / A on a
surface of area A, which keeps a larger object from winning for its size.  If it went on from where it was, as an
explorer does that stays on a face or on a side, the density is that of the contacts before, q, whatever the
object is.  The share r of the latter is integrated out, for each object by itself::

    p(places | object) = integral over r in [0, 1] of  product over i of  ((1 - r) / A + r q_i)
    q_i = mean over j < i and widths h of  exp(-|z_i - z_j|^2 / 2 h^2) / (2 pi h^2)

so that many contacts close together speak once for a small object, not each (our derivation; a kernel density
along the surface, whose widths are shares of how far the contacts scatter).  Contacts that all lie on one flat
face were drawn from that: of no body does much more than half of the surface face one way, for its normals sum to
nothing, so that n contacts from anywhere do so less than once in 2^(n - 2) times.  How much else there is they
cannot tell: r is 1, and only the place of the first depends on the object.  So it is with those that all lie on
one round face: q spills over its edges, and would favor an object of little area by that much for each contact.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.spatial.distance import cdist

from primitives.arrays import Floats, frozen

_WIDTHS = (0.6, 0.2, 0.06)  # of the contacts' root mean square distance from their middle
_LEAST = 0.5  # [mm] of a width
_NODES = 4  # of the integral over r


class Places(NamedTuple):
    """Densities that do not depend on the object, and the nodes of the integral over r."""

    local: Floats  # (n,) q of each contact [1/mm^2]; nan of the first, which has none before it
    shares: Floats  # (m,) r
    weights: Floats  # (m,) that sum to one
    anywhere: bool  # whether they may have come from all of the surface

    def densities(self, area: float) -> Floats:
        """(m, n) [1/mm^2] of each contact's place on a surface of `area` [mm^2], for each share."""
        mixed = (1.0 - self.shares[:, None]) / area + self.shares[:, None] * self.local
        return np.where(np.isfinite(mixed), mixed, 1.0 / area)

    def log_density(self, area: float, counts: Floats) -> float:
        """Logarithm of p(places | object), each of n places counted (n,) so much."""
        if not self.anywhere:
            return -float(np.log(area)) * float(counts[0]) + float(np.log(self.local[1:]) @ counts[1:])
        each = np.log(self.densities(area)) @ counts
        most = float(each.max())
        return most + float(np.log(self.weights @ np.exp(each - most)))


def places_of(points: Floats, anywhere: bool = True) -> Places:
    """Of (n, 3) points [mm], in the order in which they were felt; `anywhere`: not all on one face."""
    return Places(_local(points), *_shares(), anywhere)


@cache
def _shares() -> tuple[Floats, Floats]:
    """Gauss-Legendre nodes between 0 and 1, and their weights."""
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    return frozen(0.5 * (nodes + 1.0)), frozen(0.5 * weights)


def _local(points: Floats) -> Floats:
    n = len(points)
    wide = float(np.sqrt(((points - points.mean(axis=0)) ** 2).sum(axis=1).mean()))
    square = cdist(points, points, "sqeuclidean")
    total = np.zeros((n, n))
    for share in _WIDTHS:
        h2 = max(share * wide, _LEAST) ** 2
        total += np.exp(-0.5 * np.minimum(square / h2, 700.0)) / (2.0 * np.pi * h2)
    before = np.tril(total, -1).sum(axis=1) / len(_WIDTHS)
    return np.where(np.arange(n) > 0, before / np.maximum(np.arange(n), 1), np.nan)
