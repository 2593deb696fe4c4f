"""The skin as a grid of cells, and how its rubber spreads pressure onto the taxels.

A cell holds the indentation as Legendre coefficients up to total degree three (`MODES`), so the place of an
edge in a cell is not lost in the rubber, nor is the edge widened.  Up to degree two a step through a cell's middle
came out wider by 0.0035 mm, as much as a rounding of 0.5 mm makes it.  The spread is separable: with the
Gaussian G of standard deviation sigma, the response of taxel c to mode i of cell k along one axis is

    S_i[c, k] = 1/w_c  int_taxel dx  int_cell P_i(u(y)) G(x - y) dy ,

with mirror images of G at the skin's two ends: what presses on the rubber is carried by what lies under it,
so a uniform press reads the same on every taxel (our derivation).  Without spread the cells under the taxels
are the taxels.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.special import ndtr

from exploration.sensing.spec import SensorSpec
from primitives.arrays import Floats, frozen

# Degree in x, degree in y
MODES = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3))


@dataclass(frozen=True)
class Skin:
    """Cells of the skin, in the sensor frame, and the spread along both axes."""

    x_edges: Floats  # (C + 1,) [mm]
    y_edges: Floats  # (R + 1,) [mm]
    columns: slice  # the cells under taxels
    rows: slice
    spread_x: Floats  # (4, columns, C) for degrees 0 to 3
    spread_y: Floats  # (4, rows, R)

    @property
    def shape(self) -> tuple[int, int]:
        """(R, C) cells."""
        return len(self.y_edges) - 1, len(self.x_edges) - 1

    @property
    def areas(self) -> Floats:
        """(R, C) [mm^2]."""
        return np.outer(np.diff(self.y_edges), np.diff(self.x_edges))


def legendre(u: Floats, v: Floats) -> Floats:
    """(10, n) functions whose means against a depth are its modes."""
    weights = np.array([(2 * i + 1) * (2 * j + 1) for i, j in MODES])
    out: Floats = weights[:, None] * shapes(u, v)
    return out


def shapes(u: Floats, v: Floats) -> Floats:
    """(10, n) what a mode of 1 mm is at (n,) places of a cell, -1 to 1 along both its sides [mm]."""
    p, q = polynomials(u), polynomials(v)
    return np.stack([p[i] * q[j] for i, j in MODES])


def polynomials(u: Floats) -> Floats:
    """(4, n) Legendre's, of degree 0 to 3."""
    return np.stack([np.ones_like(u), u, (3 * u**2 - 1) / 2, (5 * u**3 - 3 * u) / 2])


def staggered_lattice(side: int) -> tuple[Floats, Floats]:
    """`side`^2 points of a cell: each row and column shifted, so that none lines up with an edge."""
    i, j = np.meshgrid(np.arange(side), np.arange(side), indexing="ij")
    order = np.argsort((np.arange(side) * 0.6180339887) % 1.0)
    u = (2 * (j + (order[i] + 0.5) / side) / side - 1).ravel()
    v = (2 * (i + (order[j] + 0.5) / side) / side - 1).ravel()
    return u, v


@lru_cache(maxsize=32)
def skin_of(spec: SensorSpec) -> Skin:
    """The cells of a sensor's skin: one under each taxel, and the margin in cells of at most one pitch."""
    x_edges, columns = _edges(spec.array.columns, spec.array.pitch[0], spec.elastomer.margin)
    y_edges, rows = _edges(spec.array.rows, spec.array.pitch[1], spec.elastomer.margin)
    sigma = spec.elastomer.spread
    return Skin(
        frozen(x_edges),
        frozen(y_edges),
        columns,
        rows,
        frozen(spread_onto(x_edges, x_edges[:-1][columns], x_edges[1:][columns], sigma)),
        frozen(spread_onto(y_edges, y_edges[:-1][rows], y_edges[1:][rows], sigma)),
    )


def _edges(count: int, pitch: float, margin: float) -> tuple[Floats, slice]:
    inner = (np.arange(count + 1) - count / 2) * pitch
    rings = int(np.ceil(margin / pitch - 1e-9))
    ring = np.linspace(0.0, margin, rings + 1)[1:]
    return np.concatenate([inner[0] - ring[::-1], inner, inner[-1] + ring]), slice(rings, rings + count)


def spread_onto(edges: Floats, lo: Floats, hi: Floats, sigma: float) -> Floats:
    """(4, taxels, cells) responses of taxels from `lo` to `hi`; without spread each taxel must be a cell.

    The exact integral over the taxel, Gauss-Legendre over the cell.
    """
    cells = len(edges) - 1
    if sigma == 0.0:
        out = np.zeros((4, len(lo), cells))
        out[0, np.arange(len(lo)), np.searchsorted(edges, lo - 1e-9)] = 1.0
        return out
    width = np.diff(edges)
    parts = max(1, int(np.ceil(float(width.max()) / sigma)))
    node, weight = np.polynomial.legendre.leggauss(12)
    u = np.concatenate([(2 * k + 1 + node) / parts - 1 for k in range(parts)])
    w = np.tile(weight / (2 * parts), parts)
    y = (edges[:-1] + edges[1:])[:, None] / 2 + width[:, None] / 2 * u
    seen = np.zeros((len(lo), *y.shape))
    for image in (y, 2 * edges[0] - y, 2 * edges[-1] - y):
        seen += ndtr((hi[:, None, None] - image) / sigma) - ndtr((lo[:, None, None] - image) / sigma)
    seen /= (hi - lo)[:, None, None]
    return np.asarray(np.einsum("tkq,mq,q,k->mtk", seen, polynomials(u), w, width))
