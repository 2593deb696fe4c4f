"""Where one surface is two faces: contacts on it that lie farther apart than chance leaves them.

A strip between them is empty (`strips`), or a ring round some of them: contacts at a density rho on a surface are
all linked, but for a share of exp(-c), when those nearer than sqrt((ln n + c) / (pi rho)) are (Penrose 1997, "The
longest edge of the random minimal spanning tree").  That holds where the face is wider than such a length, which
the number of contacts within it tells.

It was chance that spread the contacts where they fill surfaces: four times as many lie within twice a distance.
Within strokes there are twice as many, and gaps between those tell nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from primitives.arrays import Floats, Ints
from primitives.segmentation.strips import StripOptions, apart
from primitives.segmentation.unrolled import unrolled
from primitives.shapes import Shape

_MEDIAN = {2: 1.678, 4: 3.67, 16: 15.67}  # of pi rho d^2, d to such a neighbor of a Poisson field


@dataclass(frozen=True)
class PartOptions:
    """How sure a gap must be."""

    surprise: float = 6.0  # c
    slack: float = 2.0  # factor on the distance
    filled: float = 0.6  # share of the contacts due within it, below which the face is too narrow to tell
    least: int = 3  # contacts of a part
    even: float = 0.7  # density among 16 neighbors over that among 4, below which contacts fill no surface
    strips: StripOptions = field(default_factory=StripOptions)


def density(points: Floats, options: PartOptions | None = None) -> float:
    """[1/mm^2] of (n, d) contacts on the surface; 0 where they do not fill one, or are too few to tell."""
    options = options or PartOptions()
    near, far = _density(points, 4), _density(points, 16)
    return 0.0 if 0.0 < far < options.even * near else near


def _density(points: Floats, neighbor: int) -> float:
    if len(points) < neighbor + 2:
        return 0.0
    reach = np.asarray(cKDTree(points).query(points, k=neighbor + 1)[0])[:, neighbor]
    return float(_MEDIAN[neighbor] / (np.pi * max(float(np.median(reach)), 1e-9) ** 2))


def parts(shape: Shape, points: Floats, rho: float, options: PartOptions | None = None) -> list[Ints]:
    """Rows of (n, 3) contacts on a surface by the face that they are of; `rho` [1/mm^2] of all fall on one."""
    options = options or PartOptions()
    if rho <= 0:
        return [np.arange(len(points))]
    out: list[Ints] = []
    for rows in _linked(points, rho, options):
        flat = unrolled(shape, points[rows])
        if flat is None:
            out.append(rows)
        else:
            thin = min(rho, _density(flat, 2) or rho)  # by the nearest, which a rim cuts off least
            out += [rows[part] for part in apart(flat, thin, options.strips)]
    return out


def _linked(points: Floats, rho: float, options: PartOptions) -> list[Ints]:
    n = len(points)
    everyone = [np.arange(n)]
    if n < 2 * options.least:
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
