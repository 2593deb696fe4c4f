"""Tare: take what the skin reads in free air for its zero.

Zeros creep with temperature and time.  In free air every reading is the zero and noise; where the readings
stand out of the noise as a whole, their mean becomes the new zero, and else nothing changes, so that a quiet
sensor gains no error from the averaging.

Property class: none; it keeps the others honest.
"""

from dataclasses import dataclass, replace

import numpy as np

from exploration.control.dwell import dwell
from exploration.devices.guard import Guard
from primitives.arrays import frozen


@dataclass(frozen=True)
class TareConfig:
    """How long, and from when a zero has crept."""

    frames: int = 12
    crept: float = 1.4  # root mean square of the averaged readings over their standard deviation


def tare(guard: Guard, config: TareConfig = TareConfig()) -> bool:
    """Renew the zero of the active array, which must touch nothing; whether it had crept."""
    image = dwell(guard, config.frames).image
    live = np.isfinite(image.sigma)
    if not live.any() or float(np.sqrt(np.mean((image.depth[live] / image.sigma[live]) ** 2))) < config.crept:
        return False
    before = guard.calibrations[guard.active]
    zero = before.zero + image.depth * before.gain * before.stiffness
    renewed = replace(before, zero=frozen(np.where(live, zero, before.zero)))
    guard.calibrations = tuple(renewed if i == guard.active else c for i, c in enumerate(guard.calibrations))
    return True
