"""The law of a stroke: force along the normal, the pad tangent to the surface, speed along a heading.

All of it is aimed from where the pad will be once the commands still on their way are done.  Gone on by t (2,) and
tilted by a, the pad's center feels the slope g - K t + a, and its contact, at c, is pressed deeper by
z + a . (c - t); moving on at v the slope would change at the rate -K v, which turning at
w = ((K v)_y, -(K v)_x, 0) takes away beforehand (our derivation).

Wanted is the nominal press.  As a force it is the mean pressure that this press makes in a contact of this form,
which is followed slowly, on the area in contact, followed faster: where the face ends under part of the pad the
force goes down with the area, and what remains is pressed no deeper.
"""

from dataclasses import dataclass

import numpy as np

from exploration.control.feel import Felt
from exploration.control.hybrid import PRESS, HybridGains, HybridState, hybrid
from exploration.control.surface_reading import SurfaceReading
from exploration.devices.guard import Guard, Observation
from primitives.arrays import Floats


@dataclass(frozen=True)
class SurfaceServoConfig:
    """How fast what is felt is believed, and how hard the stage is driven."""

    pressure_time: float = 0.25  # [s] over which the mean pressure of the nominal press is averaged
    area_time: float = 0.05  # [s] the area in contact
    bend_time: float = 0.05  # [s] the curvature that is turned for
    least_area: float = 20.0  # [mm^2] the force of a smaller contact is not a press error
    sharpest: float = 0.2  # [1/mm] of curvature that is turned for
    effort: float = 0.5  # share of the stage's accelerations
    wrong: float = (
        0.15  # [mm] of press error beyond which depth is regulated, as force may be of another contact
    )


class SurfaceServo:
    """One stroke's controller."""

    def __init__(
        self,
        guard: Guard,
        press: float = PRESS,
        config: SurfaceServoConfig = SurfaceServoConfig(),
    ) -> None:
        self.guard, self.press, self.config = guard, press, config
        self.wanted: list[float] = []  # [N] of each tick
        self.forces: list[float] = []  # [N]
        self.bend = np.zeros((2, 2))  # [1/mm] felt, followed
        self._law = HybridGains.for_delay(guard.period, guard.pending.latency)
        self._state = HybridState()
        self._pressure = self._area = self._speed = 0.0
        self._ticks = 0

    def rest(self) -> None:
        """The pad has been standing, or was moved by another."""
        self._speed, self._state = 0.0, HybridState()

    def twist(
        self, seen: Observation, felt: Felt, reading: SurfaceReading | None, heading: Floats, speed: float
    ) -> Floats:
        """The (6,) twist of this tick, along a (2,) unit heading at up to `speed` [mm/s]."""
        depth, slope, hessian = _felt(felt, reading)
        missing = self._missing(seen, felt, depth)
        self._bent(hessian)
        soon = self.guard.pending.motion(seen.time)
        moved, tilt = soon[:2, 3], np.array([-soon[0, 2], -soon[1, 2]])
        missing -= float(soon[2, 3] + tilt @ (felt.centroid - moved))
        going = self._ramped(speed, heading) * heading
        turn = self.bend @ going
        wish = np.array([going[0], going[1], 0.0, turn[1], -turn[0], 0.0])
        twist, self._state = hybrid(
            self._state,
            missing,
            slope - self.bend @ moved + tilt,
            felt.centroid,
            wish,
            self.guard.period,
            self._law,
        )
        return twist

    def _missing(self, seen: Observation, felt: Felt, depth: float) -> float:
        """[mm] of press that is missing, by force; by depth while that is far off."""
        self._ticks += 1
        period, config = self.guard.period, self.config
        share = max(1.0 / self._ticks, period / config.area_time)
        self._area += share * (felt.area - self._area)
        pressure = seen.force / max(self._area, config.least_area) * self.press / max(depth, 0.05)
        if self._pressure == 0.0:
            self._pressure = pressure
        self._pressure += max(1.0 / self._ticks, period / config.pressure_time) * (pressure - self._pressure)
        wanted = self._pressure * max(self._area, config.least_area)
        self.wanted.append(wanted)
        self.forces.append(seen.force)
        short = self.press - depth
        if abs(short) > config.wrong:
            return short
        return (wanted - seen.force) / (seen.image.stiffness * max(felt.area, config.least_area))

    def _bent(self, hessian: Floats) -> None:
        most = float(np.abs(np.linalg.eigvalsh(hessian)).max())
        if most > self.config.sharpest:
            hessian = hessian * (self.config.sharpest / most)
        share = max(1.0 / self._ticks, self.guard.period / self.config.bend_time)
        self.bend = self.bend + share * (hessian - self.bend)

    def _ramped(self, speed: float, heading: Floats) -> float:
        """Toward a speed, no faster than the stage can follow with its turning."""
        limits = self.guard.stage.limits
        bend = max(float(np.linalg.norm(self.bend @ heading)), 1e-6)
        most = self.config.effort * min(limits.acceleration, limits.turn_acceleration / bend)
        step = most * self.guard.period
        self._speed += float(np.clip(speed - self._speed, -step, step))
        return self._speed


def _felt(felt: Felt, reading: SurfaceReading | None) -> tuple[float, Floats, Floats]:
    """Depth at the contact's middle, slope at the pad's center, and Hessian."""
    if reading is None:
        return felt.depth, felt.slope, felt.hessian
    return reading.depth_at(felt.centroid), reading.slope, reading.hessian
