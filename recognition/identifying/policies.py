"""Where to touch next without asking the belief: at random, evenly, or where the widest gap is.

These are what the choice by information is measured against, and what is done while there is no belief yet.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from exploration.planning.touching.lone_touch import Approach
from exploration.planning.ways.round_ball import Ball
from primitives.arrays import Floats
from primitives.pose import random_rotation
from recognition.matching.next_touch.candidates import directions, toward

Policy = Callable[
    [Ball, Floats, int, np.random.Generator], Approach
]  # ball, places touched, how many, chance
_EVEN = 32  # directions of the even grid, in an order that is spread out from its beginning


def random_touch(ball: Ball, felt: Floats, tried: int, rng: np.random.Generator) -> Approach:
    """From any side, at any place of the ball's middle half."""
    way = random_rotation(rng)[:, 2]
    off = rng.normal(size=3) * 0.3 * ball.radius
    return toward(ball, ball.center + off - way * float(off @ way), way, rng)


def grid_touch(ball: Ball, felt: Floats, tried: int, rng: np.random.Generator) -> Approach:
    """The next of an even grid of directions, at the middle."""
    ways = directions(_EVEN)
    order = _spread_out(ways)
    return toward(ball, ball.center, -ways[order[tried % _EVEN]], rng)


def gap_touch(ball: Ball, felt: Floats, tried: int, rng: np.random.Generator) -> Approach:
    """At the middle, from the side that is farthest from everything that was tried; `felt` (n, 3) [mm]."""
    ways = directions(128) @ random_rotation(rng).T
    if len(felt):
        seen = felt - ball.center
        seen = seen / np.maximum(np.linalg.norm(seen, axis=1, keepdims=True), 1e-9)
        ways = ways[[int(np.argmin((ways @ seen.T).max(axis=1)))]]
    return toward(ball, ball.center, -ways[0], rng)


def _spread_out(ways: Floats) -> list[int]:
    order = [0]
    nearest = ways @ ways[0]
    while len(order) < len(ways):
        order.append(int(np.argmin(nearest)))
        nearest = np.maximum(nearest, ways @ ways[order[-1]])
    return order


POLICY: dict[str, Policy] = {"random": random_touch, "grid": grid_touch, "largest-gap": gap_touch}
