"""From pressure to counts: gain, hysteresis, drift, noise, dead taxels, saturation, quantization.

Signals are in counts above the offset until `saturate`.  A stage whose number is zero does nothing and draws
nothing.
"""

from dataclasses import dataclass

import numpy as np

from exploration.sensing.spec import Electronics, SensorSpec
from primitives.arrays import Bools, Floats, frozen


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
    signal = pressure * (unit.gain * spec.counts_per_pressure)
    signal, play = hysteresis(signal, memory.play, spec.elastomer.hysteresis * e.plateau)
    zero = drift(memory.drift, e.drift * e.plateau * np.sqrt(dt), rng)
    signal = noise(signal + zero, e.noise * e.plateau, rng)
    if e.dead:
        signal = np.where(unit.dead, 0.0, signal)
    return quantize(saturate(signal + e.offset, e), e), Memory(play, zero)


def hysteresis(signal: Floats, play: Floats, half_width: float) -> tuple[Floats, Floats]:
    """The play operator: the output follows only what moves it by more than `half_width`, and never pulls."""
    if half_width == 0.0:
        return signal, play
    followed = np.clip(play, np.maximum(signal - half_width, 0.0), signal + half_width)
    return followed, followed


def drift(zero: Floats, step: float, rng: np.random.Generator) -> Floats:
    """A random walk of each taxel's zero."""
    return zero if step == 0.0 else np.asarray(zero + step * rng.standard_normal(zero.shape))


def noise(signal: Floats, sigma: float, rng: np.random.Generator) -> Floats:
    """White, on every reading."""
    return signal if sigma == 0.0 else np.asarray(signal + sigma * rng.standard_normal(signal.shape))


def saturate(counts: Floats, electronics: Electronics) -> Floats:
    """Between zero and full scale."""
    return np.minimum(np.maximum(counts, 0.0), electronics.full_scale)


def quantize(counts: Floats, electronics: Electronics) -> Floats:
    """Whole counts, where there is a converter."""
    return np.rint(counts) if electronics.bits else counts
