"""Cells of space that an array and its housing have passed through: nothing stands there.

A cell counts as swept once its middle was in the box of skin and housing, a margin inside.
"""

from __future__ import annotations

import numpy as np

from exploration.planning.known.swept_kernel import holds, sweep
from primitives.arrays import Bools, Floats, Ints, frozen
from primitives.pose import inverse

_CELL = 4.0  # [mm]
_MOST = 256  # cells along one side of the workspace; in a larger one they are larger
_NOTED = (3.0, 0.1)  # [mm] of the way, and of the attitude's matrix, after which the box is noted again
_WITHIN = 1.0  # [mm] of the housing, where there is surely nothing else
_SKIN = 1.6  # [mm] behind the skin, as deep as anything may press into it
_INNER, _OUTER = frozen(np.full(3, _WITHIN)), frozen([_WITHIN, _WITHIN, _SKIN])


class SweptCells:
    """Of a (6,) workspace box [mm]; grows with every motion."""

    def __init__(self, box: Floats) -> None:
        self._low, high = np.asarray(box[:3], dtype=float), np.asarray(box[3:], dtype=float)
        self.cell = max(_CELL, float((high - self._low).max()) / _MOST)
        self._swept = np.zeros(np.ceil((high - self._low) / self.cell).astype(int) + 1, dtype=bool)
        self._aside = np.zeros_like(self._swept)
        self._last = np.full((4, 4), np.inf)  # the pose that was noted last

    def pass_through(self, pose: Floats, low: Floats, high: Floats) -> None:
        """Note the box between two (3,) corners [mm] at a (4, 4) pose, unless it hardly moved."""
        sweep(self._swept, self._low, self.cell, self._last, _NOTED, pose, low + _INNER, high - _OUTER)

    def ahead(self, pose: Floats, low: Floats, high: Floats) -> Floats:
        """(n, 3) middles [mm] of the cells not swept that the box at a (4, 4) pose was about to move into."""
        last = self._last if np.isfinite(self._last).all() else pose
        rows = self._filled(pose @ inverse(last) @ pose, low, high)
        return np.asarray(self._low + self.cell * rows[~self._swept[tuple(rows.T)]])

    def set_aside(self, places: Floats) -> None:
        """Take (n, 3) places [mm] for not worth a look: nobody was there, so that they may hold anything."""
        self._mark(self._aside, self._rows(places))

    def holds(self, places: Floats) -> Bools:
        """(n,) whether the cell of each of (n, 3) places was swept; none outside the workspace was."""
        rows = self._rows(places)
        inside = self._inside(rows)
        out = np.zeros(len(places), dtype=bool)
        out[inside] = self._swept[tuple(rows[inside].T)]
        return out

    def holds_box(self, pose: Floats, low: Floats, high: Floats) -> bool:
        """Whether every cell in a box at a (4, 4) pose was swept, as far as the workspace reaches."""
        return bool(holds(self._swept, self._low, self.cell, pose, low, high))

    def between(self, low: Floats, high: Floats) -> Floats:
        """(n, 3) middles [mm] of the cells between two (3,) corners that were swept."""
        rows = self._lattice(self._rows(low[None])[0], self._rows(high[None])[0])
        return np.asarray(self._low + self.cell * rows[self._swept[tuple(rows.T)]])

    def unseen_between(self, low: Floats, high: Floats) -> Floats:
        """(n, 3) middles [mm] of the cells between two (3,) corners that are yet worth a look."""
        rows = self._lattice(self._rows(low[None])[0], self._rows(high[None])[0])
        done = self._swept[tuple(rows.T)] | self._aside[tuple(rows.T)]
        return np.asarray(self._low + self.cell * rows[~done])

    def _filled(self, pose: Floats, low: Floats, high: Floats) -> Ints:
        """(n, 3) the cells whose middles are surely in the box at a (4, 4) pose."""
        middle, half = pose[:3, :3] @ (0.5 * (low + high)), np.abs(pose[:3, :3]) @ (0.5 * (high - low))
        ends = pose[:3, 3] + middle + np.outer([-1.0, 1.0], half)
        rows = self._lattice(*self._rows(ends))
        at = (self._low + self.cell * rows - pose[:3, 3]) @ pose[:3, :3]
        return np.asarray(rows[((at > low + _INNER) & (at < high - _OUTER)).all(axis=1)])

    def _lattice(self, first: Ints, last: Ints) -> Ints:
        """(n, 3) all cells of the workspace from one to another."""
        top = np.array(self._swept.shape) - 1
        spans = zip(np.clip(first, 0, top + 1), np.clip(last, -1, top), strict=True)
        axes = [np.arange(a, b + 1) for a, b in spans]
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)

    def _mark(self, cells: Bools, rows: Ints) -> None:
        cells[tuple(rows[self._inside(rows)].T)] = True

    def _inside(self, rows: Ints) -> Bools:
        return np.asarray(((rows >= 0) & (rows < self._swept.shape)).all(axis=1))

    def _rows(self, places: Floats) -> Ints:
        return np.asarray(np.round((places - self._low) / self.cell).astype(np.int64))
