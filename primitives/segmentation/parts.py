"""Where one surface is two faces: contacts on it that lie farther apart than chance leaves them.

Contacts at a density rho on a surface are all linked, but for a share of exp(-c), when those nearer than
sqrt((ln n + c) / (pi rho)) are (Penrose 1997, "The longest edge of the random minimal spanning tree").  That holds
where the face is wider than such a length, which the number of contacts within it tells.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from primitives.arrays import Floats, Ints

_FOURTH = 3.67  # median of pi rho d^2, d to the fourth neighbor of a Poisson field


@dataclass(frozen=True)
class PartOptions:
    """How sure a gap must be."""

    surprise: float = 6.0  # c
    slack: float = 2.0  # factor on the distance
    filled: float = 0.6  # share of the contacts due within it, below which the face is too narrow to tell
    least: int = 3  # contacts of a part


def density(points: Floats) -> float:
    """[1/mm^2] of contacts on the surface."""
    if len(points) < 6:
        return 0.0
    reach = np.asarray(cKDTree(points).query(points, k=5)[0])[:, 4]
    return float(_FOURTH / (np.pi * max(float(np.median(reach)), 1e-9) ** 2))


def parts(points: Floats, rho: float, options: PartOptions | None = None) -> list[Ints]:
    """Rows of the (n, 3) contacts of a surface by the face that they lie on."""
    options = options or PartOptions()
    n = len(points)
    everyone = [np.arange(n)]
    if n < 2 * options.least or rho <= 0:
        return everyone
    reach = options.slack * float(np.sqrt((np.log(n) + options.surprise) / (np.pi * rho)))
    pairs = cKDTree(points).query_pairs(reach, output_type="ndarray")
    around = np.bincount(pairs.ravel(), minlength=n)
    if np.median(around) < options.filled * rho * np.pi * reach**2:
        return everyone
    graph = csr_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    count, label = connected_components(graph, directed=False)
    found = [np.flatnonzero(label == k) for k in range(count)]
    return found if min(len(part) for part in found) >= options.least else everyone
