"""From raw counts to indentation, by what the user of a real array knows of it.

signal = (counts - zero) / gain / stiffness and depth = curve(signal), with sigma = noise / gain / stiffness times
the curve's slope, infinite at dead taxels.  Where a gain is known only to a relative sigma, a taxel that feels
`signal` has sigma^2 + (gain sigma signal slope)^2.  Errors of spread and stiffness are common to all taxels: they
blur and scale the whole image, so they stay beside it and out of each taxel's sigma.

A reading at the end of its range says only that the press is at least so deep, and one that a controller held at
zero only that it is below its threshold.  Both are censored: as sigma they get what they leave open, the saturated
`CLIPPED` of their depth, the zeros beside touched taxels the threshold (farther ones feel nothing anyway).
"""

from dataclasses import dataclass
from functools import cached_property
from math import inf

import numba
import numpy as np
from scipy.ndimage import maximum_filter

from exploration.sensing.capacitive import capacitive
from exploration.sensing.curve import STRAIGHT, Curve, ParallelPlates
from exploration.sensing.frame import TactileImage, TaxelArray, TaxelFrame
from exploration.sensing.response import Response
from exploration.sensing.spec import SensorSpec
from primitives.arrays import Bools, Floats, frozen
from primitives.errors import PalpateError

CLIPPED = 0.3  # relative 1 sigma of a press that saturates its taxel
_QUANTIZATION = 1.0 / 12.0  # [counts^2] variance of rounding


@dataclass(frozen=True)
class Calibration:
    """What turns counts into indentation, and how well it is known."""

    zero: Floats  # (rows, columns) [counts] of an untouched taxel
    gain: Floats  # (rows, columns) [counts / (N/mm^2)] of a faint press
    dead: Bools  # (rows, columns)
    spread: float  # [mm] standard deviation of the point spread, rubber and all
    stiffness: float  # [N/mm^3]
    noise: float  # [counts] 1 sigma of a reading
    margin: float = inf  # [mm] of skin past the outer taxels
    gain_sigma: float | Floats = 0.0  # relative 1 sigma to which the gains are known; (rows, columns) or one
    spread_sigma: float = 0.0  # [mm]
    stiffness_sigma: float = 0.0  # [N/mm^3]
    curve: Curve = STRAIGHT  # from signal to depth
    response: Response | None = None  # across an edge; None for rubber of `spread`
    full_scale: float = inf  # [counts] that no reading exceeds
    threshold: float = 0.0  # [counts] above zero, below which readings arrive as the zero

    @property
    def counts_per_depth(self) -> Floats:
        """(rows, columns) [counts / mm] of a faint press."""
        out: Floats = self.gain * self.stiffness
        return out

    @cached_property
    def per_count(self) -> Floats:
        """(rows, columns) [mm / count] of a faint press."""
        return frozen(1.0 / self.counts_per_depth)

    @cached_property
    def quiet(self) -> Floats:
        """(rows, columns) [mm] sigma of an untouched taxel; infinite where it is dead."""
        return frozen(np.where(self.dead, np.inf, self.noise * self.per_count))

    @cached_property
    def usual_gain_sigma(self) -> float:
        """Relative 1 sigma to which a gain is known, root mean square."""
        return float(np.sqrt(np.mean(np.square(self.gain_sigma))))

    @cached_property
    def gain_sigmas(self) -> Floats:
        """(rows, columns) relative 1 sigma to which each gain is known."""
        return frozen(np.broadcast_to(self.gain_sigma, self.zero.shape))

    @staticmethod
    def nominal(spec: SensorSpec) -> "Calibration":
        """From the data sheet alone: gains are known to their spread, dead taxels not at all."""
        shape = spec.array.shape
        noise = spec.electronics.noise * spec.electronics.plateau
        spread, curve, response = spec.elastomer.spread, STRAIGHT, None
        if spec.capacitor is not None:
            curve = ParallelPlates(spec.capacitor.gap)
            response = capacitive(
                spread, spec.capacitor.fringe, spec.array.pitch, spec.capacitor.gap, spec.press_depth
            )
            spread = float(np.hypot(spread, np.sqrt(2.0) * spec.capacitor.fringe))
        return Calibration(
            frozen(np.full(shape, spec.electronics.offset)),
            frozen(np.full(shape, spec.counts_per_pressure)),
            frozen(np.zeros(shape), np.bool_),
            spread,
            spec.elastomer.stiffness,
            float(np.sqrt(noise**2 + _QUANTIZATION)),
            spec.elastomer.margin,
            spec.electronics.gain_spread,
            curve=curve,
            response=response,
            full_scale=spec.electronics.full_scale,
        )


def correct(frame: TaxelFrame, calibration: Calibration, array: TaxelArray) -> TactileImage:
    """The indentation image of a frame."""
    if frame.counts.shape != array.shape or calibration.zero.shape != array.shape:
        raise PalpateError(
            f"frame {frame.counts.shape}, calibration {calibration.zero.shape} and array {array.name} "
            f"{array.shape} differ in shape: use the calibration made for this array"
        )
    signal, noise, most = _signals(
        frame.counts,
        calibration.zero,
        calibration.per_count,
        calibration.quiet,
        calibration.dead,
        calibration.gain_sigmas,
    )
    if calibration.threshold > 0.0 or most >= calibration.full_scale:
        noise = np.hypot(noise, _censored(frame.counts, signal, calibration.per_count, calibration))
    depth = signal
    if calibration.curve is not STRAIGHT:
        depth, noise = calibration.curve.depth(signal), noise * calibration.curve.slope(signal)
    depth.flags.writeable = noise.flags.writeable = False
    return TactileImage(
        array,
        depth,
        noise,
        calibration.spread,
        calibration.stiffness,
        frame.time,
        calibration.margin,
        calibration.usual_gain_sigma,
        calibration.response,
        _saturated(frame, calibration) if most >= calibration.full_scale else None,
    )


def _saturated(frame: TaxelFrame, calibration: Calibration) -> Bools:
    return (frame.counts >= calibration.full_scale) & ~calibration.dead


@numba.njit(cache=True, error_model="numpy")
def _signals(
    counts: Floats, zero: Floats, per_count: Floats, quiet: Floats, dead: Bools, gain_sigmas: Floats
) -> tuple[Floats, Floats, float]:
    """(rows, columns) [mm] of a straight curve's depth and its sigma; the greatest count."""
    signal, noise = np.empty(counts.shape), np.empty(counts.shape)
    most = -np.inf
    for i in range(counts.shape[0]):
        for j in range(counts.shape[1]):
            value = 0.0 if dead[i, j] else (counts[i, j] - zero[i, j]) * per_count[i, j]
            signal[i, j] = value
            noise[i, j] = np.sqrt(quiet[i, j] ** 2 + (gain_sigmas[i, j] * max(value, 0.0)) ** 2)
            most = max(most, counts[i, j])
    return signal, noise, most


def _censored(counts: Floats, signal: Floats, per_count: Floats, calibration: Calibration) -> Floats:
    """(rows, columns) [mm] what saturated and thresholded readings leave open."""
    saturated = counts >= calibration.full_scale
    held = counts == calibration.zero
    rim = held & maximum_filter((~held).astype(np.uint8), 3, mode="constant").astype(bool)
    low = calibration.threshold * per_count * rim
    return np.where(saturated, CLIPPED * signal, low)
