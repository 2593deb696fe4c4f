"""From pressure to counts: gain, hysteresis, drift, noise, dead taxels, saturation, quantization.

Signals are in counts above the offset until they are converted.  A stage whose number is zero does nothing and
draws nothing.  All stages of a frame are one pass over its taxels.
"""

from dataclasses import dataclass
from math import sqrt

import numba
import numpy as np

from exploration.sensing.spec import SensorSpec
from primitives.arrays import Bools, Floats, frozen

_SILENT = np.empty((0, 0))


@dataclass(frozen=True)
class Unit:
    """One specimen of a sensor: what differs from unit to unit."""

    gain: Floats  # (rows, columns) relative to nominal
    dead: Bools  # (rows, columns)


@dataclass(frozen=True)
class Memory:
    """What the rubber and the electronics remember from frame to frame."""

    play: Floats  # (rows, columns) [counts] state of the hysteresis
    drift: Floats  # (rows, columns) [counts]

    @staticmethod
    def fresh(spec: SensorSpec) -> "Memory":
        """Of a sensor just switched on and never touched."""
        return Memory(frozen(np.zeros(spec.array.shape)), frozen(np.zeros(spec.array.shape)))


def draw_unit(spec: SensorSpec, rng: np.random.Generator) -> Unit:
    """A specimen at random."""
    e = spec.electronics
    gain = 1.0 + e.gain_spread * rng.standard_normal(spec.array.shape)
    dead = rng.random(spec.array.shape) < e.dead
    return Unit(frozen(np.maximum(gain, 0.05)), frozen(dead, np.bool_))


def read_out(
    pressure: Floats, spec: SensorSpec, unit: Unit, memory: Memory, dt: float, rng: np.random.Generator
) -> tuple[Floats, Memory]:
    """(rows, columns) counts of one frame, `dt` [s] after the frame before."""
    e = spec.electronics
    step = e.drift * e.plateau * sqrt(dt)
    counts, play, zero = _counted(
        pressure,
        (unit.gain, unit.dead),
        spec.counts_per_pressure,
        (memory.play, memory.drift),
        spec.elastomer.hysteresis * e.plateau,
        rng.standard_normal(pressure.shape) if step else _SILENT,
        step,
        rng.standard_normal(pressure.shape) if e.noise else _SILENT,
        e.noise * e.plateau,
        e.offset,
        e.full_scale,
    )
    counts.flags.writeable = play.flags.writeable = zero.flags.writeable = False
    return counts, Memory(play, zero)


@numba.njit(cache=True, error_model="numpy")
def hysteresis(signal: float, play: float, half_width: float) -> float:
    """The play operator: the output follows only what moves it by more than `half_width`, and never pulls."""
    return min(max(play, max(signal - half_width, 0.0)), signal + half_width)


@numba.njit(cache=True, error_model="numpy")
def converted(counts: float, full_scale: float) -> float:
    """Between zero and full scale; whole, where there is a converter."""
    counts = min(max(counts, 0.0), full_scale)
    return np.rint(counts) if full_scale < np.inf else counts


@numba.njit(cache=True, error_model="numpy")
def _counted(
    pressure: Floats,
    unit: tuple[Floats, Bools],
    per_pressure: float,
    memory: tuple[Floats, Floats],
    half_width: float,
    walk: Floats,
    step: float,
    white: Floats,
    sigma: float,
    offset: float,
    full_scale: float,
) -> tuple[Floats, Floats, Floats]:
    """Counts, and the states of hysteresis and drift, a random walk of each taxel's zero, after them."""
    gain, dead = unit
    play, zero = memory
    counts, after, drift = np.empty(pressure.shape), play.copy(), zero.copy()
    for i in range(pressure.shape[0]):
        for j in range(pressure.shape[1]):
            signal = pressure[i, j] * (gain[i, j] * per_pressure)
            if half_width > 0.0:
                signal = hysteresis(signal, play[i, j], half_width)
                after[i, j] = signal
            if len(walk):
                drift[i, j] += step * walk[i, j]
            signal += drift[i, j]
            if sigma > 0.0:
                signal += sigma * white[i, j]
            counts[i, j] = converted(offset + (0.0 if dead[i, j] else signal), full_scale)
    return counts, after, drift
