"""Elasticity: press, back off, touch again; what did not come back is the permanent set (Stansfield's procedure).

The height of the surface is where the pad's contact stands less the depth of the skin, at a light press.  Each
touch brings an error of its own, so several light touches come before the press and several after; their scatter
is the sigma.

Property class: surface (hardness, its plastic part).
"""

from dataclasses import dataclass

import numpy as np

from exploration.control.procedures.approach import advance, retreat
from exploration.control.procedures.hardness import NotPressed
from exploration.control.procedures.press import PRESS, PressConfig, Presser, deepest, find_spot
from exploration.devices.guard import Guard

SERVES = "surface: hardness"


@dataclass(frozen=True)
class ElasticityConfig:
    """Touches, and how they are made."""

    touches: int = 4  # before, and after
    back: float = 3.0  # [mm] off the surface between two
    speed: float = 8.0  # [mm/s] of touching again
    ticks: int = 80  # of each light touch
    hold: int = 60  # ticks of the deep press


@dataclass(frozen=True)
class Elasticity:
    """What of a press stays."""

    permanent_set: float  # [mm] by which the surface lies deeper than before
    sigma: float  # [mm]
    given: float  # [mm] that the object gave way under the press
    force: float  # [N] of the press

    @property
    def recovered(self) -> float | None:
        """Share of what it gave that came back; None where it gave no more than the error."""
        return None if self.given < 3.0 * self.sigma else 1.0 - self.permanent_set / self.given


def elasticity(
    guard: Guard, config: ElasticityConfig = ElasticityConfig(), pressing: PressConfig = PRESS
) -> Elasticity | NotPressed:
    """From a flush contact; ends in contact, at a light press."""
    spot = find_spot(guard, pressing)
    if spot is None:
        return NotPressed("no contact to press on; approach and settle first")
    deep, why = deepest(guard, pressing)
    if deep < pressing.least * pressing.light:
        return NotPressed(why)
    presser = Presser(guard, spot, pressing)
    direction, home = presser.normal, guard.world_from_sensor

    def height() -> float | None:
        """Back off and touch again."""
        retreat(guard, config.back)
        guard.go_to(_over(home, direction, config.back))
        if advance(guard, direction, 3.0 * config.back, config.speed) is None:
            return None
        again = Presser(guard, spot, pressing)
        again.normal = direction
        travel, depth = again.hold_at(pressing.light, config.ticks)
        return travel - depth

    before = [height() for _ in range(config.touches)]
    presser = Presser(guard, spot, pressing)
    presser.normal = direction
    travel, depth = presser.hold_at(deep, config.hold)
    force = guard.hold().force
    after = [height() for _ in range(config.touches)]
    if None in before or None in after:
        return NotPressed("the surface was not met again")
    was, now = np.array(before, dtype=float), np.array(after, dtype=float)
    sigma = float(np.sqrt((was.var(ddof=1) + now.var(ddof=1)) / config.touches))
    given = travel - depth - float(was.mean())
    return Elasticity(float(now.mean() - was.mean()), sigma, given, force)


def _over(home: np.ndarray, direction: np.ndarray, back: float) -> np.ndarray:
    """The pose `back` [mm] before a (4, 4) one."""
    over = home.copy()
    over[:3, 3] -= back * direction
    return over
