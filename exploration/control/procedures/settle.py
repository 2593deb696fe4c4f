"""Settle: roll the pad until it lies on the surface (Stansfield's *contact*: null the moments).

A first contact may be a vertex under the middle of the pad or a face under its rim.  Turning about the contact,
so that the slope at the pad's center vanishes, rolls the pad off vertices and edges until it lies flush on a face
or tangent to a curved one.  Balanced on something sharp, where no slope shows, it is moved aside and rolls on.

A rim that is narrower than the pad can lie on is only pressed, at the attitude that the pad came at, and no deeper
than a face would be: what is so narrow reads as less deep than it is.

Depth and slope are those that will be once the commands still on their way are done (`devices.pending`).

Property class: structural (surface normal).
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from exploration.control.feel import Felt, feel
from exploration.control.hybrid import PRESS, PRESS_AND_LEVEL, PRESS_ONLY, HybridGains, HybridState, hybrid
from exploration.devices.guard import Guard
from primitives.arrays import Floats


@dataclass(frozen=True)
class SettleConfig:
    """When the pad counts as settled, and how long it may take."""

    slope: float = 0.012  # [mm/mm] at the pad's center
    depth: float = 0.08  # [mm] of press error
    ticks: int = 8  # in a row within both
    patience: int = 1400  # ticks
    light_press: float = 0.3  # [mm] while still rolling
    sharp: float = 0.06  # [1/mm] a contact at least this curved is rolled off, if it can be
    shift: float = 7.0  # [mm] by which a balanced pad is moved aside
    shifts: int = 3  # as often, before what is felt is taken to be that narrow
    reach: float = 4.0  # [mm] that a lost contact is followed forward
    smoothing: float = 0.3  # share of the newest slope in the running mean
    rolls: bool = True  # else the pad keeps the attitude that it came at,
    share: float = 0.8  # and goes on by this share of the press at most, from where it felt something


AS_IT_CAME = SettleConfig(rolls=False)
NARROW = SettleConfig(shifts=0)  # what is known to be narrow is not shifted across


@dataclass(frozen=True)
class Unsettled:
    """The pad never came to lie; false in a condition."""

    reason: str
    met: Floats | None = None  # (3,) [mm] where something was felt at first, if anything was

    def __bool__(self) -> Literal[False]:
        return False


def settle(guard: Guard, press: float = PRESS, config: SettleConfig = SettleConfig()) -> Felt | Unsettled:
    """Roll from any first contact to a flush one, at the nominal press."""
    usual, law = HybridGains(), HybridGains.for_delay(guard.period, guard.pending.latency)
    gains = replace(usual, press=min(usual.press, law.press), level=min(usual.level, law.level))
    selection = PRESS_AND_LEVEL if config.rolls else PRESS_ONLY
    followed, quiet, shifts = 0.0, 0, 0
    aside, slope = np.zeros(2), None
    seen = guard.hold()
    start = seen.world_from_sensor
    for _ in range(config.patience):
        felt = feel(seen.image)
        gone = float((seen.world_from_sensor[:3, 3] - start[:3, 3]) @ start[:3, 2])
        if felt and not config.rolls and gone > config.share * press:
            return felt
        if not felt:
            followed += gains.press_speed * guard.period
            if followed > config.reach:
                return Unsettled("contact was lost and not found again ahead")
            seen = guard.move(np.array([0.0, 0.0, gains.press_speed, 0.0, 0.0, 0.0]))
            continue
        new = felt.slope if config.rolls else np.zeros(2)
        slope = new if slope is None else slope + config.smoothing * (new - slope)
        level = float(np.hypot(*slope)) < config.slope
        now = press if level else config.light_press
        quiet = quiet + 1 if level and abs(felt.depth - now) < config.depth else 0
        if quiet >= config.ticks:
            if felt.curvature[0] < config.sharp or shifts == config.shifts or not config.rolls:
                return felt
            aside, shifts, quiet = _across(felt) * config.shift, shifts + 1, 0
        step = np.clip(aside, -15.0 * guard.period, 15.0 * guard.period)
        aside = aside - step
        soon = guard.pending.motion(seen.time)
        tilt = np.array([-soon[0, 2], -soon[1, 2]])
        depth = felt.depth + float(soon[2, 3] + tilt @ felt.centroid)
        wish = np.array([*(step / guard.period), 0.0, 0.0, 0.0, 0.0])
        twist, _ = hybrid(
            HybridState(), now - depth, slope + tilt, felt.centroid, wish, guard.period, gains, selection
        )  # without memory: what is rolled upon changes
        seen = guard.move(twist)
    return Unsettled(f"no level contact within {config.patience} ticks")


def _across(felt: Felt) -> np.ndarray:
    """The direction across the sharp contact: that in which its mask is thinnest."""
    rows, columns = np.nonzero(felt.mask)
    spread = np.cov(np.stack([columns, rows]).astype(float)) if len(rows) > 2 else np.eye(2)
    return np.asarray(np.linalg.eigh(spread)[1][:, 0])
