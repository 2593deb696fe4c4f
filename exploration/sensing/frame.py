"""Tactile arrays and what they return: raw counts, and indentation images after calibration.

Sensor frame: origin at the pad's center on the undeformed skin, x along columns, y along rows, +z out of the
skin toward the object.  Taxel [0, 0] is the corner with the least x and y.  An object that indents the skin
by depth(x, y) has its surface at z = -depth, and its outward normal there is along
(-d depth/dx, -d depth/dy, -1).
"""

from dataclasses import dataclass
from functools import cached_property
from math import inf

import numpy as np

from exploration.sensing.response import Response
from primitives.arrays import Bools, Floats, frozen


@dataclass(frozen=True)
class TaxelArray:
    """The layout of an array: `rows` along y, `columns` along x."""

    name: str
    rows: int
    columns: int
    pitch: tuple[float, float]  # (x, y) [mm]

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns)."""
        return self.rows, self.columns

    @property
    def size(self) -> tuple[float, float]:
        """(x, y) extent of the sensing area [mm]."""
        return self.columns * self.pitch[0], self.rows * self.pitch[1]

    @cached_property
    def x(self) -> Floats:
        """(columns,) taxel centers [mm]."""
        return frozen((np.arange(self.columns, dtype=np.float64) - (self.columns - 1) / 2) * self.pitch[0])

    @cached_property
    def y(self) -> Floats:
        """(rows,) taxel centers [mm]."""
        return frozen((np.arange(self.rows, dtype=np.float64) - (self.rows - 1) / 2) * self.pitch[1])


@dataclass(frozen=True)
class TaxelFrame:
    """One reading of an array, as the wire delivers it."""

    counts: Floats  # (rows, columns) raw counts, whole numbers after quantization
    time: float  # [s] on the device's clock, when the scan of the first row began
    index: int  # frames since the device was opened
    temperature: float | None = None  # [deg C] of the skin, where the array has a thermal layer


@dataclass(frozen=True)
class TactileImage:
    """One frame after calibration: indentation as the taxels feel it, spread by the rubber."""

    array: TaxelArray
    depth: Floats  # (rows, columns) [mm] pressure over stiffness, averaged over the taxel
    sigma: Floats  # (rows, columns) [mm] standard deviation of `depth`; inf where the taxel is dead
    spread: float  # [mm] standard deviation of the rubber's point spread
    stiffness: float  # [N/mm^3] of the skin: force is stiffness * sum(depth) * taxel area
    time: float  # [s]
    margin: float = inf  # [mm] of skin past the outer taxels
    gain_sigma: float = 0.0  # relative 1 sigma to which gains are known; `sigma` includes it
    response: Response | None = None  # across an edge; None for rubber of `spread`
    saturated: Bools | None = None  # (rows, columns) at full scale, or past it; None where none is

    def __post_init__(self) -> None:
        for name in ("depth", "sigma"):
            array = getattr(self, name)
            if array.flags.writeable or not array.flags.c_contiguous:
                view = np.ascontiguousarray(array).view()
                view.flags.writeable = False
                object.__setattr__(self, name, view)  # one layout, for which kernels are compiled once
        if self.saturated is not None and self.saturated.flags.writeable:
            object.__setattr__(self, "saturated", frozen(self.saturated, bool))
