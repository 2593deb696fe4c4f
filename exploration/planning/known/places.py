"""Places that are remembered once each: of all that fall into one cell, the first.

What is remembered only grows, row after row in the order in which it came, so that who has seen so many rows need
look at the later ones only.
"""

from __future__ import annotations

import numpy as np

from primitives.arrays import Floats, Ints


class Places:
    """Rows of `width` numbers, one for each cell."""

    def __init__(self, width: int = 3) -> None:
        self._cells: set[tuple[int, ...]] = set()
        self._rows: Floats = np.empty((0, width))
        self._later: list[Floats] = []  # lots of rows that were not asked for yet

    def __len__(self) -> int:
        return len(self._cells)

    def add(self, cells: Ints, rows: Floats) -> None:
        """Remember those of (n, width) rows whose cell, of (n, k) numbers, is not known."""
        new = []
        for row, cell in enumerate(map(tuple, cells.tolist())):
            if cell not in self._cells:
                self._cells.add(cell)
                new.append(row)
        if new:
            self._later.append(rows[new])

    @property
    def rows(self) -> Floats:
        """(n, width) all of them."""
        if self._later:
            self._rows = np.concatenate([self._rows, *self._later])
            self._later = []
        return self._rows
