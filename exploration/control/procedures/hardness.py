"""Hardness: the object's stiffness, the skin's own taken off in series (Klatzky and Lederman's *pressure*).

Where skin and object are pressed by the same pressure p, the skin gives way by d = p / k_s and the object by
p / k_o, so the pad travels z = z0 + d (1 + k_s / k_o).  The slope s of travel against depth over slow strokes
gives

    k_o = k_s / (s - 1),      sigma(k_o) = k_s sigma(s) / (s - 1)^2 = k_o sigma(s) / (s - 1),

and over the contact's area A the object's hardness K_o = k_o A [N/mm] (our derivation).  White errors of the stage
fall on z, and d is nearly free of them, so plain least squares of z on d has no bias.  Strokes are added until
the answer is as sure as is asked, or nothing more is to be had: an object much stiffer than the skin is only known
to be stiffer than a bound.

Property class: surface (hardness).
"""

from dataclasses import dataclass
from math import inf
from typing import Literal

import numpy as np

from exploration.control.procedures.press import PRESS, PressConfig, Pressed, press
from exploration.devices.guard import Guard
from primitives.arrays import frozen

SERVES = "surface: hardness"


@dataclass(frozen=True)
class HardnessConfig:
    """How sure to be, and how long to try."""

    relative: float = 0.025  # sigma over the stiffness, at which pressing ends
    cycles: int = 3  # of loading and unloading between two looks
    most: int = 36  # cycles in all
    hopeless: float = 0.5  # relative sigma after the first cycles, from which an object counts as rigid
    sure: float = 3.0  # sigmas of giving way, below which only a bound is told


@dataclass(frozen=True)
class Hardness:
    """How an object yields under the pad."""

    stiffness: float | None  # [N/mm^3] of the surface; None where it is only known to exceed `bound`
    sigma: float  # [N/mm^3]; inf without a stiffness
    bound: float  # [N/mm^3] that it surely exceeds
    area: float  # [mm^2] of the contact
    share: float  # of a press that the skin takes, k_o / (k_s + k_o); 1 on a rigid object
    frames: int

    @property
    def hardness(self) -> float | None:
        """[N/mm] of this contact."""
        return None if self.stiffness is None else self.stiffness * self.area


@dataclass(frozen=True)
class NotPressed:
    """Nothing could be pressed; false in a condition."""

    reason: str

    def __bool__(self) -> Literal[False]:
        return False


def hardness(
    guard: Guard, config: HardnessConfig = HardnessConfig(), pressing: PressConfig = PRESS
) -> Hardness | NotPressed:
    """Press from a flush contact until the stiffness is known."""
    taken: list[Pressed] = []
    found: Hardness | None = None
    for _ in range(0, config.most, config.cycles):
        pressed = press(guard, config.cycles, pressing)
        if not pressed:
            return NotPressed(pressed.reason)
        taken.append(pressed)
        found = stiffness_of(taken, config)
        relative = inf if found.stiffness is None else found.sigma / found.stiffness
        if relative < config.relative or relative > config.hopeless:
            break
    assert found is not None
    return found


def stiffness_of(presses: list[Pressed], config: HardnessConfig = HardnessConfig()) -> Hardness:
    """The stiffness from strokes, each with an offset of its own."""
    top, bottom, off = 0.0, 0.0, []
    centered = []
    for pressed in presses:
        for stroke in np.unique(pressed.stroke):
            mine = pressed.stroke == stroke
            d, z = (v[mine] - v[mine].mean() for v in (pressed.depth, pressed.travel))
            top, bottom = top + float(d @ z), bottom + float(d @ d)
            centered.append((d, z))
    slope = top / bottom
    off = [z - slope * d for d, z in centered]
    residual = frozen(np.concatenate(off))
    sigma = float(np.sqrt(residual @ residual / max(len(residual) - len(centered) - 1, 1) / bottom))
    skin, gives = presses[0].skin, slope - 1.0
    area = float(np.mean([pressed.area for pressed in presses]))
    bound = skin / max(gives + 2.0 * sigma, 1e-9)
    if gives < config.sure * sigma:
        return Hardness(None, inf, bound, area, 1.0, len(residual))
    return Hardness(skin / gives, skin * sigma / gives**2, bound, area, 1.0 / slope, len(residual))
