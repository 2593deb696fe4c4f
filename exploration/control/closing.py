"""When a tracked edge has come round: it runs by its own start again.

Where the start lies in a corner, the first few ticks turn quickly and the edge never comes by there in the same
direction; so a second start, some way on, does as well.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exploration.control.edge_ticks import EdgeTick
from primitives.arrays import Floats


@dataclass(frozen=True)
class ClosingConfig:
    """What it is to come by."""

    aside: float = 2.0  # [mm] at most
    overlap: float = 3.0  # [mm] past its start that a closed edge is followed
    least_loop: float = 25.0  # [mm]
    second: float = 12.0  # [mm] from the first start to the second
    same_way: float = 0.8  # least cosine between the directions


@dataclass(frozen=True)
class Home:
    """Where an outline began."""

    point: Floats  # (3,) [mm]
    tangent: Floats  # (3,) unit direction of travel


def comes_by(home: Home, tick: EdgeTick, config: ClosingConfig) -> bool:
    """Whether the edge runs by there now, a little way past it."""
    gap = tick.point - home.point
    if gap @ gap > (config.aside + 3.0 * config.overlap) ** 2:
        return False
    past = float(gap @ home.tangent)
    aside = float(np.linalg.norm(gap - past * home.tangent))
    there = config.overlap < past < 3.0 * config.overlap and aside < config.aside
    return there and float(home.tangent @ tick.tangent) > config.same_way


def came_round(ticks: Sequence[EdgeTick], second: int, travel: float, config: ClosingConfig) -> int | None:
    """The tick that the edge has come back to after `travel` [mm]: the first, the `second` start's, or None."""
    for start, gone in ((0, 0.0), (second, config.second)):
        begun = ticks[start]
        if travel - gone > config.least_loop and comes_by(
            Home(begun.point, begun.tangent), ticks[-1], config
        ):
            return start
    return None
