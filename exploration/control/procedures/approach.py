"""Approach: a guarded straight move until the skin feels something (Dario's first subroutine).

`advance` stops at the first contact.  `approach` goes on to a desired force, and stops before it where the skin
grows hot, where what it meets is sharp (deep in the skin while it touches hardly any of it), and where the skin
has no more depth to give.

Property class: none; it is how every other procedure begins.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from exploration.control.hybrid import PRESS
from exploration.devices.guard import Guard, Observation
from exploration.sensing.frame import TactileImage
from exploration.sensing.load import stands_out
from primitives import pose as se3
from primitives.arrays import Floats


@dataclass(frozen=True)
class ApproachConfig:
    """When a frame counts as contact, and how fast the pad may close in."""

    speed: float = 25.0  # [mm/s] at most
    overshoot: float = 0.3  # share of the nominal force, by which a first contact may exceed it
    sharpest: float = 15.0  # [mm] radius of a ball on which that still holds
    search_share: float = 0.75  # of the greatest depth allowed, that a contact met in a search may reach
    tick: float = 0.3  # [mm] of travel in one, at most, however slow the array is read
    search_speed: float = 50.0  # [mm/s] through space that has not been seen yet
    sigmas: float = 6.0  # a taxel is touched above this many standard deviations of its noise
    taxels: int = 2  # as many neighbors must be touched, so that noise alone starts nothing
    hottest: float = 50.0  # [deg C] of the skin
    point: float = 14.0  # [mm^2] a contact this small, and
    deep: float = 1.0  # [mm] of travel into it, is sharp
    full: float = 0.9  # [mm] of the skin, beyond which a small contact is not pressed for more force
    slow: float = 5.0  # [mm/s] from contact to the desired force


@dataclass(frozen=True)
class Approached:
    """Why an approach stopped, and what was felt then; false where nothing was met."""

    stopped: Literal["force", "depth", "heat", "sharp", "nothing"]
    travel: float  # [mm]
    force: float  # [N]
    temperature: float | None  # [deg C] of the skin; None without a thermal layer

    def __bool__(self) -> bool:
        return self.stopped != "nothing"


def touched(image: TactileImage, config: ApproachConfig = ApproachConfig()) -> bool:
    """Whether the frame shows contact: neighbors that together stand far out of the noise.

    Sums over 3 x 3 taxels are compared with their own standard deviation.
    """
    return stands_out(image, config.sigmas)


def advance(
    guard: Guard,
    direction: Floats,
    distance: float,
    speed: float,
    config: ApproachConfig = ApproachConfig(),
) -> Observation | None:
    """Move at most `distance` [mm] along a (3,) world direction, attitude held; the observation that touched."""
    start = guard.world_from_sensor[:3, 3]
    speed = felt_speed(guard, speed, config)
    while float((guard.world_from_sensor[:3, 3] - start) @ direction) < distance:
        if touched(_tick(guard, direction, speed).image, config):
            return guard.hold()
    guard.hold()
    return None


def press_on(
    guard: Guard, direction: Floats, distance: float, config: ApproachConfig = ApproachConfig()
) -> Observation:
    """Move `distance` [mm] along a (3,) world direction as slowly as a skin is pressed, attitude held."""
    start = guard.world_from_sensor[:3, 3]
    while float((guard.world_from_sensor[:3, 3] - start) @ direction) < distance:
        _tick(guard, direction, config.slow)
    return guard.hold()


def _tick(guard: Guard, direction: Floats, speed: float) -> Observation:
    """One tick of motion along a (3,) world direction, attitude held."""
    twist = np.zeros(6)
    twist[:3] = guard.world_from_sensor[:3, :3].T @ (direction * speed)
    return guard.move(twist)


def approach(
    guard: Guard,
    direction: Floats,
    distance: float,
    force: float,
    config: ApproachConfig | None = None,
) -> Approached:
    """Move at most `distance` [mm] along a (3,) world direction, attitude held, until `force` [N] is felt."""
    config = config or ApproachConfig()
    start, begun = guard.world_from_sensor[:3, 3], 0.0
    seen = guard.hold()
    while True:
        gone = float((seen.world_from_sensor[:3, 3] - start) @ direction)
        touching = touched(seen.image, config)
        begun = begun if touching else gone
        why = _reason(seen, touching, gone - begun, force, config)
        if why is None and gone >= distance:
            why = "nothing"
        if why is not None:
            guard.hold()
            return Approached(why, gone, seen.force, seen.frame.temperature)
        seen = _tick(guard, direction, config.slow if touching else config.speed)


def _reason(
    seen: Observation, touching: bool, within: float, force: float, config: ApproachConfig
) -> Literal["force", "depth", "heat", "sharp", "nothing"] | None:
    """Why to stop `within` [mm] of where contact began, if there is a reason."""
    warmth = seen.frame.temperature
    if warmth is not None and warmth > config.hottest:
        return "heat"
    if not touching:
        return None
    if seen.force >= force:
        return "force"
    if _peak(seen.image) > config.full:
        return "depth"
    return "sharp" if within > config.deep and _felt_area(seen.image) < config.point else None


def _felt_area(image: TactileImage) -> float:
    """[mm^2] of contact, the rubber's spread taken off: the pressed volume over the greatest depth."""
    cell = image.array.pitch[0] * image.array.pitch[1]
    depth = np.where(np.isfinite(image.sigma), image.depth, 0.0)
    return float(depth.sum()) * cell / max(_peak(image), 1e-9) - 2.0 * np.pi * image.spread**2 - cell


def _peak(image: TactileImage) -> float:
    """[mm] mean of the two deepest taxels."""
    depth = np.where(np.isfinite(image.sigma), image.depth, 0.0)
    return float(np.sort(depth, axis=None)[-2:].mean())


def felt_speed(guard: Guard, speed: float, config: ApproachConfig = ApproachConfig()) -> float:
    """[mm/s] of an advance that was told `speed`: as slow as its array has to be moved, to stop in time."""
    return min(speed, config.tick / guard.period, soft_speed(guard, speed > config.speed, config))


def soft_speed(guard: Guard, searching: bool = False, config: ApproachConfig = ApproachConfig()) -> float:
    """[mm/s] at which a first contact stays within its overshoot; or, searching, within the guard's limits."""
    calibration, array = guard.calibrations[guard.active], guard.sensor.array
    noise = calibration.noise / float(np.median(calibration.counts_per_depth))
    felt = np.sqrt(3.0 * config.sigmas * noise * array.pitch[0] * array.pitch[1] / np.pi / config.sharpest)
    deepest = np.sqrt(1.0 + config.overshoot) * PRESS
    room = (config.search_share * guard.limits.depth if searching else deepest) - min(felt, 0.5 * deepest)
    late = guard.pending.latency + 1.5 * guard.period
    braking = guard.stage.limits.acceleration
    return float(braking * (np.sqrt(late**2 + 2.0 * room / braking) - late))


def retreat(guard: Guard, distance: float = 6.0) -> None:
    """Back straight off along the pad's own normal, which is free because the pad came from there."""
    guard.go_to(guard.world_from_sensor @ se3.pose(translation=[0.0, 0.0, -distance]))
