"""Look closely: a narrow contact is felt longer, and from a second attitude where that does not settle it.

Through blurring rubber a flat strip of two or three taxels and a thin round bar look alike in one noisy frame.
The mean of several tells strips of three taxels apart from bars; narrower ones are told apart when the pad leans
across them, because a strip then is deeper at one of its edges and a bar only elsewhere (our derivation).

Property class: structural (exact shape).
"""

from dataclasses import dataclass

import numpy as np

from exploration.control.dwell import dwell
from exploration.control.feel import Felt
from exploration.devices.guard import Guard, Observation
from exploration.sensing.surfaces.local_surface import LocalSurface
from exploration.sensing.touch import perceive


@dataclass(frozen=True)
class LookConfig:
    """When a contact is narrow, and what is done then."""

    narrow: float = 5.2  # [taxels] across, below which a contact is felt longer
    unsettled: float = 3.6  # [taxels] below which the pad leans as well, where one attitude leaves it open
    frames: int = 8  # averaged
    lean: float = 0.06  # [rad]
    rate: float = 0.8  # [rad/s]


def look_closely(
    guard: Guard, seen: Observation, felt: Felt, config: LookConfig | None = None
) -> Observation:
    """The observation to take contacts from: the one at hand, or a longer one where the contact is narrow."""
    config = config or LookConfig()
    taxels = width(felt) / max(seen.image.array.pitch)
    if taxels > config.narrow:
        return seen
    longer = dwell(guard, config.frames)
    if taxels > config.unsettled:
        return longer
    surface = perceive(longer.image).surface
    if isinstance(surface, LocalSurface) and not surface.curved:
        return longer
    _lean(guard, felt, config)
    return dwell(guard, config.frames)


def width(felt: Felt) -> float:
    """[mm] across the contact: a surface of curvature k pressed d deep touches within sqrt(2 d / k)."""
    return 2.0 * float(np.sqrt(2.0 * max(felt.depth, 0.0) / max(float(felt.curvature[0]), 1e-6)))


def _lean(guard: Guard, felt: Felt, config: LookConfig) -> None:
    """Turn the pad about the ridge of a contact, in place; the servo levels it again afterwards."""
    across = np.linalg.eigh(felt.hessian)[1][:, 1]
    wx, wy = config.rate * np.array([-across[1], across[0]])
    lift = wy * felt.centroid[0] - wx * felt.centroid[1]
    for _ in range(max(1, round(config.lean / config.rate / guard.period))):
        guard.move(np.array([0.0, 0.0, lift, wx, wy, 0.0]))
