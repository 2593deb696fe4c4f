"""The rubber: indentation to pressure (Winkler, p = k depth), spread onto the taxels; and the net load.

F = k sum(depth A); the moment on the pad about its center is
sum r x (0, 0, -p A) = (-sum y p A, sum x p A, 0).
"""

import numpy as np
from numba import njit

from exploration.sensing.physics.gap import Indentation
from exploration.sensing.physics.skin import skin_of, spread_onto
from exploration.sensing.spec import SensorSpec
from primitives.arrays import Bools, Floats, Ints, frozen

_NEGLIGIBLE = 1e-7  # share of a cell's pressure that a taxel need not feel


def pressure(felt: Indentation, spec: SensorSpec) -> Floats:
    """(..., rows, columns) [N/mm^2] mean over each taxel, after the rubber's spread."""
    rubber = Rubber(spec)
    shape = felt.deepest.shape
    modes = felt.modes.reshape(-1, *felt.modes.shape[-3:])
    partial = felt.partial.reshape(-1, *felt.partial.shape[-2:])
    out = np.stack([rubber.press(m, p) for m, p in zip(modes, partial, strict=True)])
    return out.reshape(*shape, *spec.array.shape)


class Rubber:
    """The spread of one sensor's rubber, as bands around each taxel."""

    def __init__(self, spec: SensorSpec, split: int = 1) -> None:
        """`split` cuts each taxel into so many, along x and along y."""
        skin = skin_of(spec)
        self._stiffness = spec.elastomer.stiffness
        self._x, self._y = skin.spread_x, skin.spread_y
        if split > 1:
            self._x, self._y = (
                frozen(_finer(edges, taxels, split, spec.elastomer.spread))
                for edges, taxels in ((skin.x_edges, skin.columns), (skin.y_edges, skin.rows))
            )
        self._x_band, self._y_band = _bands(self._x), _bands(self._y)
        self._shape = self._y.shape[1], self._x.shape[1]

    def press(self, modes: Floats, partial: Bools) -> Floats:
        """(rows, columns) [N/mm^2] from (10, R, C) modes; above the mean, only those of `partial` cells count."""
        out = np.zeros(self._shape)
        _spread(modes, partial, self._x, self._y, self._x_band, self._y_band, self._stiffness, out)
        return out


def _finer(edges: Floats, taxels: slice, split: int, sigma: float) -> Floats:
    lo, hi = edges[:-1][taxels], edges[1:][taxels]
    cuts = np.linspace(lo[0], hi[-1], len(lo) * split + 1)
    return spread_onto(edges, cuts[:-1], cuts[1:], sigma)


def _bands(spread: Floats) -> Ints:
    """(taxels + cells, 2): the cells that reach each taxel, then the taxels that each cell reaches."""
    reaches = np.abs(spread).max(axis=0) > _NEGLIGIBLE
    spans = [np.flatnonzero(line) for line in (*reaches, *reaches.T)]
    return frozen([(s[0], s[-1] + 1) if len(s) else (0, 0) for s in spans], np.int64)


@njit(cache=True, error_model="numpy")
def _spread(
    modes: Floats, partial: Bools, x: Floats, y: Floats, x_band: Ints, y_band: Ints, k: float, out: Floats
) -> None:
    rows, columns = out.shape
    cell_rows, cell_columns = partial.shape
    across = np.zeros((cell_rows, columns))
    line = np.zeros((4, columns))
    for r in range(cell_rows):
        for c in range(cell_columns):
            mean = k * modes[0, r, c]
            if mean == 0.0:
                continue
            first, last = x_band[columns + c]
            for t in range(first, last):
                across[r, t] += x[0, t, c] * mean
            if not partial[r, c]:
                continue
            m1, m2, m3, m4, m5, m6, m7, m8, m9 = modes[1:, r, c]
            for t in range(first, last):
                x0, x1, x2 = x[0, t, c], x[1, t, c], x[2, t, c]
                across[r, t] += k * (m1 * x1 + m3 * x2 + m6 * x[3, t, c])
                line[1, t] = k * (m2 * x0 + m4 * x1 + m7 * x2)
                line[2, t] = k * (m5 * x0 + m8 * x1)
                line[3, t] = k * m9 * x0
            above, below = y_band[rows + r]
            for s in range(above, below):
                y1, y2, y3 = y[1, s, r], y[2, s, r], y[3, s, r]
                for t in range(first, last):
                    out[s, t] += y1 * line[1, t] + y2 * line[2, t] + y3 * line[3, t]
    for s in range(rows):
        above, below = y_band[s]
        for r in range(above, below):
            weight = y[0, s, r]
            for t in range(columns):
                out[s, t] += weight * across[r, t]


def wrench(felt: Indentation, spec: SensorSpec, whole_skin: bool = False) -> Floats:
    """(..., 6) force [N] and moment [N mm] on the pad about its center, in the sensor frame.

    Over the cells under the taxels, or over the whole skin, which is what the stage feels.
    """
    skin = skin_of(spec)
    rows, columns = (slice(None), slice(None)) if whole_skin else (skin.rows, skin.columns)
    width, height = np.diff(skin.x_edges)[columns], np.diff(skin.y_edges)[rows]
    x = (skin.x_edges[:-1] + skin.x_edges[1:])[columns] / 2
    y = (skin.y_edges[:-1] + skin.y_edges[1:])[rows] / 2
    load = spec.elastomer.stiffness * np.outer(height, width) * felt.modes[..., rows, columns]
    mean, tilt_x, tilt_y = (load[..., m, :, :] for m in range(3))
    along_x = (x * mean + width / 6 * tilt_x).sum(axis=(-2, -1))
    along_y = (y[:, None] * mean + height[:, None] / 6 * tilt_y).sum(axis=(-2, -1))
    force = mean.sum(axis=(-2, -1))
    zero = np.zeros_like(force)
    return np.stack([zero, zero, -force, -along_y, along_x, zero], axis=-1)
