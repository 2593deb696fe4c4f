"""The middle of what is touched, a parabola along its longer extent, and how wide it is across that.

The crown of a ring or the rim of a cup touches along an arc: the places' own covariance calls a bent strip wide,
and points spread by it lie where nothing was felt.  Across the parabola it is as slim as it is (our derivation).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from exploration.sensing.frame import TaxelArray
from primitives.arrays import Bools, Floats


@dataclass(frozen=True)
class Midline:
    """Of the touched part of a pad."""

    center: Floats  # (2,) [mm] the touched taxels' mean place
    along: Floats  # (2,) unit, their longer extent
    across: Floats  # (2,) unit
    bend: Floats  # (3,) c0 + c1 u + c2 u^2 is how far across [mm] the middle lies, u [mm] along
    width: float  # [mm] of a straight strip as wide across
    drawn_in: float  # the width over what it would be of places that do not bend

    @staticmethod
    def of(mask: Bools, array: TaxelArray) -> Midline:
        """Through the (rows, columns) touched taxels, one or more."""
        rows, columns = np.nonzero(mask)
        places = np.stack([array.x[columns], array.y[rows]])
        center = places.mean(axis=1)
        away = places - center[:, None]
        across, along = np.linalg.eigh(away @ away.T)[1].T
        u, v = along @ away, across @ away
        bend, *_ = np.linalg.lstsq(_powers(u), v, rcond=None)
        width, all_of_it = np.sqrt(12.0 * np.mean(np.square([v - _powers(u) @ bend, v]), axis=1))
        return Midline(center, along, across, bend, float(width), float(width / max(all_of_it, 1e-9)))

    def bent(self, xy: Floats) -> Floats:
        """(n, 2) places [mm] spread over a straight strip, moved across to where the bent one is."""
        u, v = (xy - self.center) @ self.along, (xy - self.center) @ self.across
        across = _powers(u) @ self.bend + self.drawn_in * v
        places: Floats = self.center + np.outer(u, self.along) + np.outer(across, self.across)
        return places


def _powers(u: Floats) -> Floats:
    return np.stack([np.ones_like(u), u, u**2], axis=1)
