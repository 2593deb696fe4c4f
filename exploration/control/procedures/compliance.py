"""Compliance: how far the pad travels from contact until a force is reached (Stansfield's procedure).

Travel against force is a line from the contact on, z = z0 + c F, whose slope c is the compliance of skin and
object in series; their distance at a force F is c F, of which the skin itself gives F / (k_s A).

Property class: surface (hardness).
"""

from dataclasses import dataclass

import numpy as np

from exploration.control.procedures.hardness import NotPressed
from exploration.control.procedures.press import PRESS, PressConfig, press
from exploration.devices.guard import Guard

SERVES = "surface: hardness"


@dataclass(frozen=True)
class Compliance:
    """A distance from contact to a force."""

    force: float  # [N] the threshold
    distance: float  # [mm]
    sigma: float  # [mm]
    skin: float  # [mm] of it that the skin gives; the rest is the object's

    @property
    def object(self) -> float:
        """[mm] that the object gives."""
        return self.distance - self.skin


def compliance(
    guard: Guard, force: float = 20.0, cycles: int = 3, config: PressConfig = PRESS
) -> Compliance | NotPressed:
    """Press from a flush contact; the distance at `force` [N], which the line need not quite reach."""
    pressed = press(guard, cycles, config)
    if not pressed:
        return NotPressed(pressed.reason)
    f = pressed.force
    one = np.equal.outer(pressed.stroke, np.unique(pressed.stroke)).astype(float)
    basis = np.column_stack([f, one])
    fitted = np.linalg.lstsq(basis, pressed.travel, rcond=None)[0]
    residual = pressed.travel - basis @ fitted
    spread = f - one @ (one.T @ f / one.sum(axis=0))
    sigma = float(residual.std() / np.sqrt(spread @ spread))
    return Compliance(force, float(fitted[0]) * force, sigma * force, force / (pressed.skin * pressed.area))
