"""From raw counts to indentation, by what the user of a real array knows of it.

depth = (counts - zero) / gain / stiffness, with sigma = noise / gain / stiffness, infinite at dead taxels.
Where the gains are known only to a relative sigma, a taxel pressed d deep has sigma^2 + (gain sigma d)^2.
"""

from dataclasses import dataclass
from math import inf

import numpy as np

from exploration.sensing.frame import TactileImage, TaxelArray, TaxelFrame
from exploration.sensing.spec import SensorSpec
from primitives.arrays import Bools, Floats, frozen
from primitives.errors import PalpateError

_QUANTIZATION = 1.0 / 12.0  # [counts^2] variance of rounding


@dataclass(frozen=True)
class Calibration:
    """What turns counts into indentation."""

    zero: Floats  # (rows, columns) [counts] of an untouched taxel
    gain: Floats  # (rows, columns) [counts / (N/mm^2)]
    dead: Bools  # (rows, columns)
    spread: float  # [mm] standard deviation of the rubber's point spread
    stiffness: float  # [N/mm^3]
    noise: float  # [counts] 1 sigma of a reading
    margin: float = inf  # [mm] of skin past the outer taxels
    gain_sigma: float = 0.0  # relative 1 sigma to which the gains are known

    @staticmethod
    def nominal(spec: SensorSpec) -> "Calibration":
        """From the data sheet alone: gains are known to their spread, dead taxels not at all."""
        shape = spec.array.shape
        noise = spec.electronics.noise * spec.electronics.plateau
        return Calibration(
            frozen(np.full(shape, spec.electronics.offset)),
            frozen(np.full(shape, spec.counts_per_pressure)),
            frozen(np.zeros(shape), np.bool_),
            spec.elastomer.spread,
            spec.elastomer.stiffness,
            float(np.sqrt(noise**2 + _QUANTIZATION)),
            spec.elastomer.margin,
            spec.electronics.gain_spread,
        )


def correct(frame: TaxelFrame, calibration: Calibration, array: TaxelArray) -> TactileImage:
    """The indentation image of a frame."""
    if frame.counts.shape != array.shape or calibration.zero.shape != array.shape:
        raise PalpateError(
            f"frame {frame.counts.shape}, calibration {calibration.zero.shape} and array {array.name} "
            f"{array.shape} differ in shape: use the calibration made for this array"
        )
    per_count = 1.0 / (calibration.gain * calibration.stiffness)
    depth = np.where(calibration.dead, 0.0, (frame.counts - calibration.zero) * per_count)
    noise = np.hypot(calibration.noise * per_count, calibration.gain_sigma * np.maximum(depth, 0.0))
    sigma = np.where(calibration.dead, np.inf, noise)
    return TactileImage(
        array,
        frozen(depth),
        frozen(sigma),
        calibration.spread,
        calibration.stiffness,
        frame.time,
        calibration.margin,
    )
