"""How late the stage obeys, measured: a short shake in free air.

The array is told to move with velocity v(t) = speed sin(2 pi f t) along its own x.  Its encoders show the same
sine, late by the latency and by half the period for which each command holds.  The lag is fitted by linear least
squares on sin, cos, a constant and a drift, so that white noise of sigma on each of n readings costs
sqrt(2/n) sigma / amplitude radians of phase (our derivation).

Property class: none; it is what makes fast control safe.
"""

from dataclasses import dataclass

import numpy as np

from exploration.devices.guard import Guard
from primitives.errors import PalpateError


@dataclass(frozen=True)
class ShakeConfig:
    """The shake; its greatest acceleration, 2 pi f speed, stays below what any stage can do."""

    frequency: float = 4.0  # [Hz]
    speed: float = 20.0  # [mm/s]
    cycles: int = 4
    settle: int = 1  # cycles before the fit begins


@dataclass(frozen=True)
class Latency:
    """Seconds from a command to its motion, as the encoders show it."""

    seconds: float
    sigma: float


def measure_latency(guard: Guard, config: ShakeConfig = ShakeConfig()) -> Latency:
    """Shake the array in free air by `speed / (2 pi f)` (1 mm) and fit the lag of what the encoders read."""
    w = 2.0 * np.pi * config.frequency
    start = guard.world_from_sensor
    ticks = round((config.cycles + config.settle) / config.frequency / guard.period)
    times, places = [], []
    began = guard.hold().time
    now = began
    for _ in range(ticks):
        twist = np.zeros(6)
        twist[0] = config.speed * np.sin(w * (now - began))
        seen = guard.move(twist)
        now = seen.time
        times.append(now - began)
        places.append(float((seen.world_from_sensor[:3, 3] - start[:3, 3]) @ start[:3, 0]))
    guard.hold(max(1, round(0.05 / guard.period)))
    t, x = np.array(times), np.array(places)
    late = t > config.settle / config.frequency
    basis = np.stack([-np.cos(w * t), np.sin(w * t), np.ones_like(t), t], axis=1)[late]
    fitted, _, rank, _ = np.linalg.lstsq(basis, x[late], rcond=None)
    amplitude = float(np.hypot(fitted[0], fitted[1]))
    if rank < 4 or amplitude < 0.3 * config.speed / w:
        raise PalpateError(
            "the stage does not follow a small motion in free air: is it enabled, and free to move?"
        )
    lag = float(np.arctan2(-fitted[1], fitted[0])) / w
    residual = x[late] - basis @ fitted
    sigma = float(np.sqrt(2.0 / late.sum()) * residual.std() / amplitude / w)
    return Latency(max(0.0, lag - guard.period / 2.0), sigma)
