"""A straight flight at a steady, modest speed, through space where nobody has been.

The flange goes on a line and turns about one axis, both ending together, as a stage's own straight moves do; so an
array on an arm swings alike.  What decides how far it runs on after a collision is its speed, so that is what is
held, and no stop is made on the way: hops of 4 mm with a rest after each have a higher top speed and take twice as
long (our derivation).  Toward what may press the skin it goes as slowly as a search does.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from exploration.control.procedures.approach import felt_speed
from exploration.devices.guard import Guard, Observation
from primitives import pose as se3
from primitives.arrays import Floats


@dataclass(frozen=True)
class FlightConfig:
    """How fast."""

    speed: float = 75.0  # [mm/s] of the flange
    turn: float = 1.25  # [rad/s]
    share: float = 0.9  # of what the stage can do, at most
    search: float = 50.0  # [mm/s] the way that the skin looks, at most
    last: float = 0.06  # [s] before the goal at least, from where the stage ends the move by itself
    stuck: float = 0.5  # [s] without coming nearer, after which the stage is asked for the rest of the way


def fly(
    guard: Guard,
    goal: Floats,
    until: Callable[[Observation], bool],
    config: FlightConfig = FlightConfig(),
) -> Observation | None:
    """Steadily to a (4, 4) world_from_sensor; the observation that met `until`, or None once arrived.

    A goal that the stage's axes cannot take is refused as its own straight moves are.
    """
    stage = guard.stage.limits
    speed = min(config.speed, config.share * stage.speed)
    turn = min(config.turn, config.share * stage.turn_speed)
    last = max(config.last, guard.pending.latency + guard.period + speed / (2.0 * stage.acceleration))
    ahead = felt_speed(guard, config.search)
    flange_from_sensor = guard.sensor.flange_from_sensor
    flange_goal = goal @ se3.inverse(flange_from_sensor)
    nearest, since = np.inf, 0.0  # [s] before the goal, and since it came so near
    while True:
        here = guard.world_from_sensor
        flange = here @ se3.inverse(flange_from_sensor)
        line = flange_goal[:3, 3] - flange[:3, 3]
        turned = se3.rotation_log(flange_goal[:3, :3] @ flange[:3, :3].T)
        moved = line + se3.cross(turned, here[:3, 3] - flange[:3, 3])  # of the sensor, by the same twist
        left = max(float(np.linalg.norm(line)) / speed, float(np.linalg.norm(turned)) / turn)
        nearest, since = (left, 0.0) if left < nearest else (nearest, since + guard.period)
        if left < last or (since > config.stuck and not guard.stage.held):
            return guard.go_to(goal, until)
        seconds = max(left, float(moved @ here[:3, 2]) / ahead)
        seen = guard.move(np.concatenate([moved @ here[:3, :3], turned @ here[:3, :3]]) / seconds)
        if until(seen):
            guard.hold()
            return seen
