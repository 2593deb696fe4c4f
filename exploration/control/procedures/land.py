"""Land: approach and settle, and come again at a better attitude where the housing was in the way.

Property class: structural (a first contact, its surface normal).
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import uniform_filter

from exploration.control.feel import Felt
from exploration.control.procedures.approach import ApproachConfig, advance, retreat
from exploration.control.procedures.settle import SettleConfig, Unsettled, settle
from exploration.control.procedures.tare import tare
from exploration.devices.guard import Collision, Guard, Observation, OverPress
from exploration.sensing.frame import TactileImage
from primitives import pose as se3
from primitives.arrays import Floats


@dataclass(frozen=True)
class LandConfig:
    """How often, and how far the pad leans between two tries."""

    tries: int = 5
    lean: float = 0.5  # [rad]
    back: float = 12.0  # [mm]


AS_TOLD = LandConfig(tries=1)
"""At the attitude told or not at all: a pad that leans away from what its housing met lies on something else."""


def land(
    guard: Guard,
    direction: Floats,
    distance: float,
    speed: float,
    config: LandConfig = LandConfig(),
    settling: SettleConfig | None = None,
    felt_at: Floats | None = None,
) -> Felt | Unsettled:
    """Advance at most `distance` [mm] along a (3,) direction until touched, then settle.

    When the housing meets the object first, the pad backs off, leans to the side on which it felt contact, as
    settling would have rolled it, and advances along its own new normal.  With `felt_at` (2,) [mm] it leans at
    once.  What the rubber remembers of a hard contact is taken out before: it would pass for a new one.
    """
    met: Floats | None = None
    for _ in range(config.tries):
        try:
            if felt_at is not None:
                retreat(guard, config.back)
                tare(guard)
                direction = _lean(guard, felt_at, config)
                distance, speed = 3.0 * config.back, ApproachConfig().speed
            seen = advance(guard, direction, distance, speed)
            if seen is None:
                return Unsettled("nothing was met", met)
            if met is None:
                met = _place(strongest(seen.image), seen)
            settled = settle(guard, config=settling or SettleConfig())
            return settled if isinstance(settled, Felt) else replace(settled, met=met)
        except (Collision, OverPress) as fault:
            felt_at = strongest(fault.seen.image) if fault.seen is not None else np.zeros(2)
    return Unsettled(f"the housing was in the way {config.tries} times", met)


def strongest(image: TactileImage) -> Floats:
    """(2,) [mm] where the image is strongest, however weak: the side on which the object is."""
    live = np.where(np.isfinite(image.sigma), image.depth, 0.0)
    row, column = np.unravel_index(int(np.argmax(uniform_filter(live, 3))), live.shape)
    return np.array([image.array.x[column], image.array.y[row]])


def _place(at: Floats, seen: Observation) -> Floats:
    """(3,) [mm] in the world of a (2,) place of the pad."""
    pose = seen.world_from_sensor
    return np.asarray(pose[:3, :2] @ at + pose[:3, 3])


def _lean(guard: Guard, felt_at: Floats, config: LandConfig) -> Floats:
    """Turn about the felt contact so that the pad's far side comes down; the new direction of approach."""
    here = guard.world_from_sensor
    away = felt_at if float(np.hypot(*felt_at)) > 0.5 else np.array([0.0, 1.0])
    axis = here[:3, :2] @ (np.array([-away[1], away[0]]) / np.linalg.norm(away))
    contact = here[:3, :3] @ np.array([*felt_at, config.back + 5.0]) + here[:3, 3]
    turned = se3.turn_about(contact, axis, config.lean) @ here
    guard.go_to(turned)
    return np.asarray(turned[:3, 2])
