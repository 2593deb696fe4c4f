"""Press: run the pad into the surface and back, force against depth.

From a contact that lies flush, the pad is moved along its normal at a slow even speed, between a light press and a
deep one, level all the while.  Taken down each tick are how far the contact's middle has traveled, how deep it
indents the skin there, and the force.  White errors of the stage average out over a stroke; those that stay the
same over a contact change no slope.

Property class: none; compliance, elasticity and hardness read what it takes down.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from exploration.control.dwell import dwell
from exploration.control.feel import NotTouching, feel
from exploration.control.hybrid import HybridGains, HybridState, hybrid
from exploration.devices.guard import Guard, Observation
from primitives.arrays import Bools, Floats, Ints, frozen


@dataclass(frozen=True)
class PressConfig:
    """How far and how fast."""

    light: float = 0.2  # [mm] of the skin, where a stroke begins
    deep: float = 0.8  # [mm] where it turns
    speed: float = 1.0  # [mm/s]
    force_share: float = 0.8  # of the guard's limit, that a deep press may take
    scale_share: float = 0.8  # of the converter's range, likewise
    farthest: float = 12.0  # [mm] of travel, beyond which the object gives way without end
    turning: float = 0.2  # share of a stroke after each turn that is left out: skins have play
    frames: int = 8  # averaged to find the contact
    least: float = 1.5  # times the light press that a deep one must reach


PRESS = PressConfig()


@dataclass(frozen=True)
class Pressed:
    """What strokes of pressing took down; false where there was nothing to press on."""

    travel: Floats  # (n,) [mm] of the contact's middle into the object, from an arbitrary zero
    depth: Floats  # (n,) [mm] of the skin there
    force: Floats  # (n,) [N]
    stroke: Ints  # (n,) which stroke; even ones load
    skin: float  # [N/mm^3] stiffness of the skin
    area: float  # [mm^2] that carries the force
    reason: str = ""  # why there is nothing

    def __bool__(self) -> bool:
        return len(self.travel) > 0


@dataclass(frozen=True)
class Spot:
    """The contact that is pressed."""

    inner: Bools  # (rows, columns) taxels away from where contact ends
    middle: Floats  # (2,) [mm] of them

    def depth(self, seen: Observation) -> float:
        """[mm] mean over the spot."""
        return float(seen.image.depth[self.inner].mean())

    def travel(self, seen: Observation, normal: Floats) -> float:
        """[mm] of the spot's middle along a (3,) world direction."""
        place = seen.world_from_sensor
        return float((place[:3, :2] @ self.middle + place[:3, 3]) @ normal)


def press(guard: Guard, cycles: int = 1, config: PressConfig = PressConfig()) -> Pressed:
    """Load and unload so many times, from a flush contact; ends at the light press."""
    spot = find_spot(guard, config)
    if spot is None:
        return _nothing("no contact to press on; approach and settle first")
    deep, why = deepest(guard, config)
    if deep < config.least * config.light:
        return _nothing(why)
    presser = Presser(guard, spot, config)
    rows: list[tuple[float, float, float, int]] = []
    for stroke in range(2 * cycles):
        loading = stroke % 2 == 0
        limit = deep if loading else config.light
        rows += [(*row, stroke) for row in presser.stroke(limit, 1 if loading else -1)]
        if presser.gone > config.farthest:
            return _nothing(f"the object gave way for more than {config.farthest:g} mm")
    t, d, f, s = (np.array(column) for column in zip(*rows, strict=True))
    skin = guard.calibrations[guard.active].stiffness
    area = float(np.sum(f * d) / np.sum(d * d) / skin)
    return Pressed(frozen(t), frozen(d), frozen(f), frozen(s, np.int64), skin, area)


def find_spot(guard: Guard, config: PressConfig = PressConfig()) -> Spot | None:
    """The middle of the contact under the pad, at a light press, where it stays in contact."""
    whole = _spot(guard, config)
    if whole is None:
        return None
    Presser(guard, whole, config).hold_at(config.light, 80)
    return _spot(guard, config)


def _spot(guard: Guard, config: PressConfig) -> Spot | None:
    seen = dwell(guard, config.frames)
    felt = feel(seen.image)
    if isinstance(felt, NotTouching):
        return None
    inner = felt.inner if felt.inner.any() else felt.mask
    rows, columns = np.nonzero(inner)
    array = seen.image.array
    return Spot(inner, np.array([array.x[columns].mean(), array.y[rows].mean()]))


class Presser:
    """Moves the pad along its normal and keeps it level."""

    def __init__(self, guard: Guard, spot: Spot, config: PressConfig = PressConfig()) -> None:
        self.guard, self.spot, self.config = guard, spot, config
        self.normal = guard.world_from_sensor[:3, 2].copy()
        self.gains = HybridGains.for_delay(guard.period, guard.pending.latency)
        self.gone = 0.0  # [mm] commanded since the last turn
        self._law = HybridState()
        self._seen = guard.hold()

    def stroke(self, limit: float, sign: Literal[-1, 1]) -> list[tuple[float, float, float]]:
        """Rows of (travel, depth, force) until the depth passes `limit` [mm], the turn left out."""
        rows: list[tuple[float, float, float]] = []
        recent: list[float] = []
        self.gone = 0.0
        while self.gone <= self.config.farthest:
            seen = self._tick(0.0, sign * self.config.speed)
            self.gone += self.config.speed * self.guard.period
            recent = [*recent[-4:], self.spot.depth(seen)]
            rows.append((self.spot.travel(seen, self.normal), recent[-1], seen.force))
            if sign * (float(np.mean(recent)) - limit) > 0.0:
                break
        return rows[round(self.config.turning * len(rows)) :]

    def hold_at(self, depth: float, ticks: int) -> tuple[float, float]:
        """Regulate to a depth [mm]; the mean travel and depth of the last half of so many ticks."""
        rows = []
        for _ in range(ticks):
            soon = float(self.guard.pending.motion(self._seen.time)[2, 3])
            seen = self._tick(depth - self.spot.depth(self._seen) - soon, 0.0)
            rows.append((self.spot.travel(seen, self.normal), self.spot.depth(seen)))
        travel, felt = np.mean(rows[ticks // 2 :], axis=0)
        return float(travel), float(felt)

    def _tick(self, missing: float, speed: float) -> Observation:
        felt = feel(self._seen.image)
        slope, pivot = (felt.slope, felt.centroid) if felt else (np.zeros(2), np.zeros(2))
        wish = np.array([0.0, 0.0, speed, 0.0, 0.0, 0.0])
        twist, self._law = hybrid(self._law, missing, slope, pivot, wish, self.guard.period, self.gains)
        self._seen = self.guard.move(twist)
        return self._seen


def deepest(guard: Guard, config: PressConfig) -> tuple[float, str]:
    """How deep the skin may be pressed [mm] within force and range; what bounds it."""
    calibration = guard.calibrations[guard.active]
    array = guard.sensor.array
    area = array.size[0] * array.size[1]
    by_force = config.force_share * guard.limits.force / (calibration.stiffness * area)
    range_ = float(np.median((calibration.full_scale - calibration.zero) / calibration.counts_per_depth))
    by_scale = config.scale_share * range_
    deep = min(config.deep, by_force, by_scale)
    return (
        deep,
        "the force limit" if by_force < by_scale else "the array's range" + " leaves no room to press",
    )


def _nothing(reason: str) -> Pressed:
    none = frozen(np.empty(0))
    return Pressed(none, none, none, frozen(none, np.int64), 0.0, 0.0, reason)
