"""Hybrid control: each axis of the sensor frame regulates force or follows position.

With the diagonal selection S (1 where force is controlled; Raibert and Craig) the commanded twist is

    twist = S law(error) + wish,

the wish being the motion of the other axes and the feed-forward of these.  Along z the error is the press
that is missing, e = (F0 - F) / (k A) [mm], so that one gain serves large contacts and small ones; about x and y it
is the slope of the touched surface, which is the moment about the contact's centroid over k I (Winkler).  The
skin integrates velocity into indentation, hence proportional-integral action,

    v = kp e + ki (integral of e),  ki = kp^2 / 10,

whose integral stands still while the command is at its bound (anti-windup).  What is sensed is old by the latency
and half a period, and a command holds for one period: the whole delay is T = latency + 3/2 period.  With
kp = `aggression` / T the crossover lies at kp, and the phase margin is 90 - 57.3 `aggression` - 5.7 degrees,
whatever the delay (our derivation); `margins` computes both margins of the sampled loop.
"""

from dataclasses import dataclass

import numba
import numpy as np

from primitives.arrays import Bools, Floats, frozen

PRESS_AND_LEVEL = frozen(
    np.array([False, False, True, True, True, False]), np.bool_
)  # force z, moments x and y
PRESS_ONLY = frozen(np.array([False, False, True, False, False, False]), np.bool_)
INTEGRAL = 0.1  # ki / kp^2
PRESS = 0.5  # [mm] nominal indentation


@dataclass(frozen=True)
class HybridGains:
    """Gains and bounds of the force-controlled axes."""

    press: float = 15.0  # [1/s] kp along z
    level: float = 8.0  # [1/s] kp about x and y
    press_speed: float = 12.0  # [mm/s]
    level_speed: float = 1.5  # [rad/s]

    @property
    def all(self) -> tuple[float, float, float, float]:
        """As the kernels take them."""
        return self.press, self.level, self.press_speed, self.level_speed

    @staticmethod
    def for_delay(
        period: float, latency: float, aggression: float = 0.4, fastest: float = 25.0
    ) -> "HybridGains":
        """Gains for a loop that reads every `period` [s] and acts `latency` [s] late."""
        kp = min(aggression / (latency + 1.5 * period), fastest)
        return HybridGains(press=kp, level=0.6 * kp)


@dataclass(frozen=True)
class HybridState:
    """The integrals of the errors, per axis; [mm s] and [rad s]."""

    integral: tuple[float, float, float] = (0.0, 0.0, 0.0)  # z, about x, about y


def hybrid(
    state: HybridState,
    missing: float,
    slope: Floats,
    pivot: Floats,
    wish: Floats,
    period: float,
    gains: HybridGains = HybridGains(),
    selection: Bools = PRESS_AND_LEVEL,
) -> tuple[Floats, HybridState]:
    """The (6,) sensor-frame twist for one tick, and the state after it.

    `missing` [mm] is the press error; `slope` (2,) [mm/mm] of depth is felt at the pad's center; `pivot` (2,)
    [mm] is the point that levelling leaves at rest; `wish` (6,) [mm/s, rad/s] is the tracker's.
    """
    twist, integral = commanded(state.integral, missing, slope, pivot, wish, period, gains.all, selection)
    return twist, HybridState(integral)


@numba.njit(cache=True, error_model="numpy")
def commanded(
    integral: tuple[float, float, float],
    missing: float,
    slope: Floats,
    pivot: Floats,
    wish: Floats,
    period: float,
    gains: tuple[float, float, float, float],
    selection: Bools,
) -> tuple[Floats, tuple[float, float, float]]:
    """`hybrid`, for kernels."""
    press, level, press_speed, level_speed = gains
    vz, z = _regulated(missing, integral[0], press, press_speed, period)
    wx, x = _regulated(-slope[1], integral[1], level, level_speed, period)
    wy, y = _regulated(slope[0], integral[2], level, level_speed, period)
    twist = wish.copy()
    law = (0.0, 0.0, vz + wy * pivot[0] - wx * pivot[1], wx, wy, 0.0)
    for i in range(6):
        if selection[i]:
            twist[i] += law[i]
    return twist, (z, x, y)


@numba.njit(cache=True, error_model="numpy")
def _regulated(error: float, integral: float, kp: float, bound: float, period: float) -> tuple[float, float]:
    """The bounded command, and the integral after it: unchanged where that would drive further past the bound."""
    grown = integral + error * period
    command = kp * error + INTEGRAL * kp * kp * grown
    if abs(command) > bound:
        if command * error > 0.0:
            grown = integral
        command = max(-bound, min(bound, command))
    return command, grown


@dataclass(frozen=True)
class Margins:
    """How far a loop is from ringing."""

    gain: float  # factor on the gain
    phase: float  # [rad]
    delay: float  # [s] of further latency


def margins(kp: float, period: float, latency: float) -> Margins:
    """Stability margins of the sampled press loop, with skin and stage as a delayed integrator.

    L(z) = period / (z - 1) z^-(1 + latency/period) (kp + ki period z / (z - 1)) on the unit circle: one period
    passes between a frame and the command that answers it.
    """
    w = np.geomspace(1e-3 / period, np.pi / period, 20_000)[:-1]
    z = np.exp(1j * w * period)
    late = np.exp(-1j * w * latency) / z
    loop = period / (z - 1.0) * late * (kp + INTEGRAL * kp * kp * period * z / (z - 1.0))
    size, phase = np.abs(loop), np.unwrap(np.angle(loop))
    phase -= (
        2.0 * np.pi * round((phase[0] + np.pi) / (2.0 * np.pi))
    )  # a double integrator begins at -180 degrees
    crossover = int(np.argmax(size < 1.0))
    turns = np.flatnonzero((phase[1:] < -np.pi) & (phase[:-1] >= -np.pi) & (w[1:] > w[crossover] / 2.0))
    gain = float(1.0 / size[turns[0] + 1]) if len(turns) else np.inf
    margin = float(phase[crossover] + np.pi)
    return Margins(gain, margin, margin / float(w[crossover]))
