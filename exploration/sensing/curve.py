"""From a taxel's signal to indentation: the static characteristic of a sensor's physics.

`signal` is what a taxel feels in mm as if its small-signal gain held at every depth; a curve turns that into the
depth that it is, and back.  A curve rises, passes through zero and has slope 1 there.

Parallel plates: a cell's capacitance goes as 1/(g - d), g being the gap that closes, so its change is in
proportion to signal = d / (1 - d/g), and d = signal / (1 + signal/g).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Protocol

import numpy as np

from primitives.arrays import Floats, frozen
from primitives.errors import PalpateError


class Curve(Protocol):
    """A static characteristic."""

    def depth(self, signal: Floats) -> Floats:
        """[mm] indentation."""
        ...

    def signal(self, depth: Floats) -> Floats:
        """[mm] its inverse."""
        ...

    def slope(self, signal: Floats) -> Floats:
        """Slope of depth over signal."""
        ...


@dataclass(frozen=True)
class ParallelPlates:
    """Plates that the indentation brings together; straight where the gap is endless."""

    gap: float = inf  # [mm] of indentation that would close it

    def depth(self, signal: Floats) -> Floats:
        """[mm]; the plates never meet, and what noise pulls below zero stays finite."""
        out: Floats = signal / self._share(signal)
        return out

    def signal(self, depth: Floats) -> Floats:
        """[mm]."""
        out: Floats = depth / np.maximum(1.0 - depth / self.gap, 1e-3)
        return out

    def slope(self, signal: Floats) -> Floats:
        """At most 4, at readings far below zero."""
        out: Floats = 1.0 / self._share(signal) ** 2
        return out

    def _share(self, signal: Floats) -> Floats:
        out: Floats = np.maximum(1.0 + signal / self.gap, 0.5)
        return out


STRAIGHT = ParallelPlates()


@dataclass(frozen=True)
class Sampled:
    """A measured characteristic, straight between its points and beyond them."""

    signals: Floats  # (n,) rising
    depths: Floats  # (n,) [mm] rising

    @staticmethod
    def of(signals: Sequence[float], depths: Sequence[float]) -> "Sampled":
        """Checked: at least two points, both rising."""
        s, d = np.asarray(signals, dtype=float), np.asarray(depths, dtype=float)
        if s.ndim != 1 or s.shape != d.shape or len(s) < 2 or np.diff(s).min() <= 0 or np.diff(d).min() <= 0:
            raise PalpateError("a sampled curve needs two or more signals and as many depths, both rising")
        return Sampled(frozen(s), frozen(d))

    def depth(self, signal: Floats) -> Floats:
        """[mm]."""
        return _straight(signal, self.signals, self.depths)

    def signal(self, depth: Floats) -> Floats:
        """[mm]."""
        return _straight(depth, self.depths, self.signals)

    def slope(self, signal: Floats) -> Floats:
        """Of the piece."""
        k = np.clip(np.searchsorted(self.signals, signal) - 1, 0, len(self.signals) - 2)
        out: Floats = (np.diff(self.depths) / np.diff(self.signals))[k]
        return out


def _straight(at: Floats, x: Floats, y: Floats) -> Floats:
    k = np.clip(np.searchsorted(x, at) - 1, 0, len(x) - 2)
    out: Floats = y[k] + (at - x[k]) * ((y[k + 1] - y[k]) / (x[k + 1] - x[k]))
    return out
