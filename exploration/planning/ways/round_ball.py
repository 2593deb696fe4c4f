"""Ways round an object of which nothing is known but a ball that holds it.

Outside a ball of radius r, stops on a circle of radius r / cos(a / 2), a apart, make chords that never enter it.
The pad turns on its way as evenly as it moves.  At its start it goes straight out, away from the middle, and at
its end straight in (our derivation).
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from primitives import pose as se3
from primitives.arrays import Floats


@dataclass(frozen=True)
class Ball:
    """A ball that holds whatever the pad must not meet on its way."""

    center: Floats  # (3,) [mm]
    radius: float  # [mm]


@dataclass(frozen=True)
class RoundConfig:
    """How far the pad keeps away, and how often it stops."""

    clearance: float = 8.0  # [mm]
    step: float = 0.9  # [rad] between two stops, at most


def way_round(start: Floats, goal: Floats, ball: Ball, config: RoundConfig | None = None) -> list[Floats]:
    """Poses (4, 4) from `start` to `goal`, each reached in a straight line; the last is the goal."""
    config = config or RoundConfig()
    a, b = start[:3, 3] - ball.center, goal[:3, 3] - ball.center
    reach = ball.radius + config.clearance
    if _segment_distance(a, b) > reach:
        return [goal]
    angle = _angle(a, b)
    steps = max(1, int(np.ceil(angle / config.step)))
    out = reach / np.cos(0.5 * angle / steps)
    first = max(out, float(np.linalg.norm(a)))
    last = max(out, float(np.linalg.norm(b)))
    shares = np.linspace(0.0, 1.0, steps + 1)
    ways = slerp(a, b, shares)
    radii = np.full(steps + 1, out)
    radii[0], radii[-1] = first, last
    turn = se3.rotation_log(goal[:3, :3] @ start[:3, :3].T)
    attitudes = se3.rotation_exp(turn * shares[:, None]) @ start[:3, :3]
    stops = list(se3.pose(attitudes, ball.center + radii[:, None] * ways))
    if float(np.linalg.norm(stops[0][:3, 3] - start[:3, 3])) < 1e-6:
        stops = stops[1:]
    if float(np.linalg.norm(stops[-1][:3, 3] - goal[:3, 3])) > 1e-6:
        stops.append(goal)
    else:
        stops[-1] = goal
    return stops


def way_out(here: Floats, start: Floats, ball: Ball, config: RoundConfig | None = None) -> Floats:
    """(4, 4) on the straight way from `here` back to `start`, as it is turned, only out of the ball."""
    reach = ball.radius + (config or RoundConfig()).clearance
    a, b = here[:3, 3] - ball.center, start[:3, 3] - ball.center
    along = b - a
    square, half = float(along @ along), float(a @ along)
    left = half**2 - square * (float(a @ a) - reach**2)
    if square < 1e-12 or left < 0.0:
        return start
    share = float(np.clip((np.sqrt(left) - half) / square, 0.0, 1.0))
    return se3.pose(start[:3, :3], ball.center + a + share * along)


def slerp(a: Floats, b: Floats, shares: Floats) -> Floats:
    """(n, 3) unit directions from (3,) a to (3,) b along the shorter great circle."""
    u, v = a / max(float(np.linalg.norm(a)), 1e-9), b / max(float(np.linalg.norm(b)), 1e-9)
    angle = _angle(u, v)
    if angle < 1e-6:
        return np.tile(u, (len(shares), 1))
    across = v - u * float(u @ v)
    if float(np.linalg.norm(across)) < 1e-6:
        across = np.cross(u, np.eye(3)[int(np.argmin(np.abs(u)))])
    across = across / np.linalg.norm(across)
    turned: Floats = np.cos(shares * angle)[:, None] * u + np.sin(shares * angle)[:, None] * across
    return turned


def length_of(start: Floats, poses: list[Floats]) -> tuple[float, float]:
    """Travel [mm] and turning [rad] of a way."""
    path = [start, *poses]
    travel = turning = 0.0
    for p, q in itertools.pairwise(path):
        travel += float(np.linalg.norm(q[:3, 3] - p[:3, 3]))
        turning += se3.turn_between(p, q)
    return travel, turning


def _angle(a: Floats, b: Floats) -> float:
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


def _segment_distance(a: Floats, b: Floats) -> float:
    """Least distance [mm] of the segment between two points to the origin."""
    along = b - a
    share = float(np.clip(-(a @ along) / max(float(along @ along), 1e-12), 0.0, 1.0))
    return float(np.linalg.norm(a + share * along))
