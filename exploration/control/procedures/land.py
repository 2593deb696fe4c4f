"""Land: approach and settle, and come again at a better attitude where the housing was in the way.

Property class: structural (a first contact, its surface normal).
"""

from dataclasses import dataclass

import numpy as np

from exploration.control.feel import Felt, feel
from exploration.control.procedures.approach import ApproachConfig, advance, retreat
from exploration.control.procedures.settle import Unsettled, settle
from exploration.devices.guard import Collision, Guard, OverPress
from primitives import pose as se3
from primitives.arrays import Floats


@dataclass(frozen=True)
class LandConfig:
    """How often, and how far the pad leans between two tries."""

    tries: int = 5
    lean: float = 0.5  # [rad]
    back: float = 12.0  # [mm]


def land(
    guard: Guard, direction: Floats, distance: float, speed: float, config: LandConfig = LandConfig()
) -> Felt | Unsettled:
    """Advance at most `distance` [mm] along a (3,) direction until touched, then settle.

    When the housing meets the object first, the pad backs off, leans to the side on which it felt contact, as
    settling would have rolled it, and advances along its own new normal.
    """
    for _ in range(config.tries):
        centroid = np.zeros(2)
        try:
            met = advance(guard, direction, distance, speed)
            if met is None:
                return Unsettled("nothing was met")
            felt = feel(met.image)
            centroid = felt.centroid if felt else centroid
            return settle(guard)
        except (Collision, OverPress):
            retreat(guard, config.back)
            direction = _lean(guard, centroid, config)
            distance, speed = 3.0 * config.back, ApproachConfig().speed
    return Unsettled(f"the housing was in the way {config.tries} times")


def _lean(guard: Guard, centroid: Floats, config: LandConfig) -> Floats:
    """Turn about the felt contact so that the pad's far side comes down; the new direction of approach."""
    here = guard.world_from_sensor
    away = centroid if float(np.hypot(*centroid)) > 0.5 else np.array([0.0, 1.0])
    axis = here[:3, :2] @ (np.array([-away[1], away[0]]) / np.linalg.norm(away))
    contact = here[:3, :3] @ np.array([*centroid, config.back + 5.0]) + here[:3, 3]
    turned = se3.turn_about(contact, axis, config.lean) @ here
    guard.go_to(turned)
    return np.asarray(turned[:3, 2])
