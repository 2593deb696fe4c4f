"""An approach as six numbers from -1 to 1, and back.

With the ball that holds the object (center c, radius R), an action (a, u, v, t) approaches along the unit vector
of a (3 numbers; along -z where they are all 0), through the place c + `ASIDE` R (u x + v y), x and y being the
first two axes of the frame that `frame_along` gives that direction, with the pad turned by pi t about it.
"""

from __future__ import annotations

import numpy as np

from exploration.planning.touching.lone_touch import Approach
from exploration.planning.ways.round_ball import Ball
from primitives import pose as se3
from primitives.arrays import Floats
from recognition.matching.next_touch.candidates import toward

SIZE = 6
ASIDE = 0.9  # of the ball's radius, how far off its middle an approach may aim
_DOWN = np.array([0.0, 0.0, -1.0])


def approach_of(action: Floats, ball: Ball) -> Approach:
    """The approach that an action means."""
    told = np.clip(np.asarray(action, dtype=float)[:SIZE], -1.0, 1.0)
    length = float(np.linalg.norm(told[:3]))
    way = told[:3] / length if length > 1e-6 else _DOWN
    frame = se3.frame_along(way)
    place = ball.center + ASIDE * ball.radius * (frame[:, :2] @ told[3:5])
    straight = toward(ball, place, way)
    turn = frame @ se3.rotation_exp(np.array([0.0, 0.0, np.pi * told[5]]))
    return Approach(se3.pose(turn, straight.start[:3, 3]), straight.length)


def action_of(approach: Approach, ball: Ball) -> np.ndarray:
    """(6,) float32: the action that means an approach, as nearly as there is one."""
    way = approach.direction
    frame = se3.frame_along(way)
    aside = (approach.start[:3, 3] - ball.center) @ frame[:, :2] / (ASIDE * ball.radius)
    across = approach.start[:3, 0] @ frame
    turn = np.arctan2(across[1], across[0]) / np.pi
    told = np.concatenate([way, aside, [turn]])
    return np.asarray(np.clip(told, -1.0, 1.0), dtype=np.float32)
