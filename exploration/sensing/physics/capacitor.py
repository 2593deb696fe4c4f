"""Taxels that measure a gap: from the rubber's compression to a change of capacitance.

The compression d under each sixteenth of a taxel makes d / (1 - d/g) (`curve.ParallelPlates`); the fringing field
weighs what lies r away by K0(r/L) / (2 pi L^2), the solution of (1 - L^2 laplacian) h = delta, so each of the
cosine waves of a pad whose guard ring lets no field out shrinks by 1 / (1 + L^2 k^2); the electrode sums.
"""

from typing import Protocol

import numpy as np
from scipy.fft import dctn, idctn

from exploration.sensing.curve import ParallelPlates
from exploration.sensing.physics.elastomer import Rubber
from exploration.sensing.spec import Capacitor, SensorSpec
from primitives.arrays import Bools, Floats

_SPLIT = 4  # strips of a taxel along each axis


class Transducer(Protocol):
    """From the skin's indentation to what the electronics read."""

    def press(self, modes: Floats, partial: Bools) -> Floats:
        """(rows, columns) [N/mm^2], or what gives the same signal, from (10, R, C) modes."""
        ...


def transducer(spec: SensorSpec) -> Transducer:
    """What a sensor's taxels measure."""
    return Rubber(spec) if spec.capacitor is None else Plates(spec, spec.capacitor)


class Plates:
    """Electrodes under the rubber."""

    def __init__(self, spec: SensorSpec, capacitor: Capacitor) -> None:
        self._rubber = Rubber(spec, _SPLIT)
        self._stiffness, self._curve = spec.elastomer.stiffness, ParallelPlates(capacitor.gap)
        rows, columns = spec.array.shape
        ky = np.pi * np.arange(rows * _SPLIT) / (rows * spec.array.pitch[1])
        kx = np.pi * np.arange(columns * _SPLIT) / (columns * spec.array.pitch[0])
        self._kept = 1.0 / (1.0 + capacitor.fringe**2 * (ky[:, None] ** 2 + kx**2))

    def press(self, modes: Floats, partial: Bools) -> Floats:
        """See `Transducer`: the pressure at which the signal's small-signal gain would give it."""
        pressed = self._rubber.press(modes, partial)
        if not pressed.any():
            return pressed[::_SPLIT, ::_SPLIT]
        signal = self._curve.signal(pressed / self._stiffness)
        waves: Floats = dctn(signal, norm="ortho")
        spread: Floats = idctn(waves * self._kept, norm="ortho")
        rows, columns = (n // _SPLIT for n in spread.shape)
        mean: Floats = spread.reshape(rows, _SPLIT, columns, _SPLIT).mean(axis=(1, 3))
        return mean * self._stiffness
