"""The hybrid law: force along the skin's normal, tilt from the felt slope, position along the rest.

The sensor's z axis is force controlled: indentation error drives v_z.  The two tilts null the slope of the
touched surface at the pad's center: with depth = d + gx x + gy y, turning the pad at (wx, wy) changes the slope
at the rate (-wy, wx), so ``w = gain (-gy, gx)`` lets it decay.  What is left, motion in the tangent plane and the
turn about the normal, is position controlled by the tracker that calls.
"""

from dataclasses import dataclass

import numpy as np

from primitives.arrays import Floats


@dataclass(frozen=True)
class ServoGains:
    """Gains and bounds of the law; the products gain * period stay well below 1, so it cannot ring."""

    press: float = 0.5  # [mm] wanted indentation
    depth_gain: float = 15.0  # [1/s]
    tilt_gain: float = 8.0  # [1/s]
    press_speed: float = 12.0  # [mm/s] bound on v_z
    tilt_speed: float = 1.5  # [rad/s] bound on the tilt rates


def hybrid_twist(
    depth: float,
    slope: Floats,
    pivot: Floats,
    along: Floats,
    turn: float = 0.0,
    gains: ServoGains = ServoGains(),
) -> Floats:
    """The (6,) sensor-frame twist for one tick.

    `depth` [mm] and `slope` (2,) [mm/mm] are felt; `pivot` (2,) [mm] is the point of the pad that tilting should
    leave at rest; `along` (2,) [mm/s] and `turn` [rad/s] are the tracker's wish in the tangent plane.
    """
    vz = float(np.clip(gains.depth_gain * (gains.press - depth), -gains.press_speed, gains.press_speed))
    wx, wy = -gains.tilt_gain * slope[1], gains.tilt_gain * slope[0]
    rate = float(np.hypot(wx, wy))
    if rate > gains.tilt_speed:
        wx, wy = wx * gains.tilt_speed / rate, wy * gains.tilt_speed / rate
    lift = wy * pivot[0] - wx * pivot[1]
    return np.array([along[0], along[1], vz + lift, wx, wy, turn])
